#pragma once

#include "ident/repeats.hpp"
#include "ident/spectra.hpp"

namespace struna::ident {

/// welch_spectra of records wherever they are.
Spectra welch_spectra(const Repeats& repeats, const WelchOptions& options);

}  // namespace struna::ident
