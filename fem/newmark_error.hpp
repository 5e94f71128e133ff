#pragma once

#include <complex>

#include "fem/material.hpp"
#include "fem/newmark.hpp"

namespace struna::fem {

/// The pole [1/s] that the scheme gives to a vibration of that frequency and damping ratio, of positive
/// frequency; the true one is w (-zeta + i sqrt(1 - zeta^2)). From the amplification matrix (Hughes, The
/// Finite Element Method, eqs. (9.1.14)-(9.1.16)).
std::complex<double> newmark_pole(const NewmarkOptions& options, double f_hz, double damping_ratio);

/// Relative rms error that the scheme leaves in a response without contact up to `highest_hz` over
/// `duration` [s]. It shifts a vibration's pole (constant average acceleration: too slow by (w dt)^2/12,
/// Bathe, section 9.4; lambda > 1/2: damped), and that adds up while it rings, for 1/(zeta w) or the
/// duration. Over the whole band, where lower resonances are shifted less, an eighth of what the upper edge
/// tells shows (docs/limits.md: within a factor 2 where it is some per cent).
double newmark_error(const NewmarkOptions& options, double highest_hz, const Rayleigh& rayleigh,
                     double duration);

}  // namespace struna::fem
