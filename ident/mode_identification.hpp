#pragma once

#include <vector>

#include "ident/mode.hpp"

namespace struna::ident {

enum class ModeMethod { automatic, circle, half_power, multi };
ModeMethod mode_method(
    const std::string& word);  ///< "auto", "circle", "half-power", "multi"; throws Error on another
std::string to_string(ModeMethod method);

struct ModeOptions {
  ModeMethod method = ModeMethod::automatic;
  fem::Damping damping = fem::Damping::structural;
  double band_lo_hz = 0.0;  ///< 0, 0: all lines
  double band_hi_hz = 0.0;
  std::vector<double> frequencies_hz;  ///< given by the user: these only …
  std::vector<double> extra_hz;        ///< … or these besides the ones found
};

/// Resonances over all outputs together, the window of each, and the method's fit. automatic: circles start
/// and illustrate, the multi-mode fit refines, poles are added while the residual demands one (and dropped
/// when nothing supports them); several references (references.hpp) part what one cannot
/// (refine_with_references). Flags say what cannot be trusted; candidates that are no mode go to
/// `rejected`.
ModeSet identify_modes(const TransferFunction& tf, const ModeOptions& options = {});

}  // namespace struna::ident
