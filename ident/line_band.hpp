#pragma once

#include "ident/transfer_function.hpp"

namespace struna::ident {

/// A closed interval of frequencies.
struct Span {
  double lo_hz = 0.0;
  double hi_hz = 0.0;
  bool holds(double f_hz) const { return f_hz >= lo_hz && f_hz <= hi_hz; }
};

/// The band of a function and the distance of its lines.
struct LineBand : Span {
  double spacing_hz = 0.0;
};
LineBand band_of(const TransferFunction& tf);

}  // namespace struna::ident
