#pragma once

#include <optional>
#include <vector>

#include "ident/resonance.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident {

/// Resonances that stand out by themselves: peaks of y = sqrt(sum over outputs of |H|^2), each output in
/// units of its median, from which y falls on either side by 15 % and by five standard deviations of either
/// line before it counts (hysteresis: a peak within noise or ripple is none); then the same for means of y^2
/// over 3, 9, 27 ... lines with the noise that these leave, for peaks that the finer scales have not shown.
/// The loss factor comes from the steeper flank's half-power point. `tf` in circle form with sigma.
std::vector<Pole> find_peaks(const TransferFunction& tf);

/// The pole whose share, alone, would take most out of a residual already divided by sigma (lines x outputs):
/// matched filter 1/(x + i), x = 2 (f - f_r)/bandwidth, over frequencies in [lo_hz, hi_hz] and bandwidths 2,
/// 4, 8 ... line spacings up to 0.3 f, skipping positions within a bandwidth of `tried`. Wide filters run
/// over lines added up, so the cost is a few operations per line. nullopt where nothing gains more than
/// `least_gain` of the sum of squares.
struct ResidualPole {
  Pole pole;
  double gain = 0.0;
};
std::optional<ResidualPole> strongest_pole(const TransferFunction& tf, const Eigen::MatrixXcd& residual,
                                           double lo_hz, double hi_hz, const std::vector<Pole>& tried,
                                           double least_gain);

}  // namespace struna::ident
