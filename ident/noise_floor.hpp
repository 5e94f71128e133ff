#pragma once

#include "ident/transfer_function.hpp"

namespace struna::ident {

/// Standard deviation of the real and of the imaginary part at each line, from the function itself: noise is
/// what jumps from line to line. Fourth differences z_-2 - 4 z_-1 + 6 z_0 - 4 z_1 + z_2 (variance 70 sigma^2)
/// vanish for what is smooth; the median of their squares over 41 lines passes over sharp resonances. Never
/// below 1e-6 of the neighbourhood's median magnitude.
Eigen::VectorXd noise_from_differences(const Eigen::VectorXcd& value);

/// The function with a sigma for each output: the given one averaged (in square) over nine lines, since sigma
/// from few averages scatters by itself and a line that is accidentally coherent must not rule a fit; where
/// none is given, noise_from_differences.
TransferFunction with_noise_floor(const TransferFunction& tf);

/// Whether every output brought its sigma.
bool has_sigma(const TransferFunction& tf);

}  // namespace struna::ident
