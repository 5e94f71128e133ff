#pragma once

#include "ident/mode.hpp"

namespace struna::ident {

// Thresholds of the flags.
inline constexpr double coarse_lines =
    4.0;  ///< fewer line spacings in the half-power band: coarse, where the estimator's leakage is not known
inline constexpr double coarse_doubt = 0.05;       ///< of the loss factor, by leakage that is known, and also
                                                   ///< more than its standard error: coarse
inline constexpr double noisy_frequency = 0.05;    ///< standard error of the frequency over the bandwidth
inline constexpr double noisy_loss_factor = 0.10;  ///< relative standard error of the loss factor
inline constexpr double poor_circle_misfit =
    3.0;  ///< weighted rms distance from the geometric circle, and also
inline constexpr double poor_circle_scatter = 0.02;  ///< rms distance over radius, in the best output
inline constexpr double unseen_pair =
    0.2;  ///< bandwidths; noise that hides equal modes farther apart: may_be_two
inline constexpr double double_mode_noise =
    2.0;  ///< second singular value over the largest that noise makes, and also
inline constexpr double double_mode_share = 0.012;  ///< over the first singular value, and also
inline constexpr double double_mode_shape = 0.35;   ///< part of its energy that has the shape of g^2

/// Whether a multi-mode fit has taken the neighbours out: the values are not a circle's own.
bool is_refined(const Mode& mode);

/// Whether the function was seen too coarsely for the mode's loss factor. `leakage_hz`: see TransferFunction.
bool is_coarse(const Mode& mode, double line_spacing_hz, double leakage_hz);
bool is_noisy(const Mode& mode);  ///< false where the method has no standard errors
bool reaches_edge(const Mode& mode, double band_lo_hz, double band_hi_hz);
/// Whether the other is too close for this mode's values. From a circle: within a half-power bandwidth, the
/// larger of the two, as its circle then is not this mode's own. From a multi-mode fit, which takes the other
/// out: where their frequencies differ by less than five standard errors.
bool are_close(const Mode& mode, const Mode& other);

/// Whether two modes stand behind one pole. Its lines alone (lines x outputs, all else subtracted, each
/// output over its sigma) are then of rank two: to first order in the distance of the two, C g + D g^2 with D
/// not parallel to C, where a single mode gives (column g) x (row of constants). So the second singular
/// vector must rise above noise, whose largest singular value is about sqrt(2) (sqrt(lines) + sqrt(outputs -
/// 1)), and have the shape of g^2: leakage and remains of neighbours have not.
bool looks_double(const Eigen::MatrixXcd& alone, const Eigen::VectorXcd& g);

/// Whether noise would hide a second mode more than unseen_pair away, and none has been noticed.
bool may_be_two(const Mode& mode);

/// Adds the flag unless the mode has it.
void add_flag(Mode& mode, ModeFlag flag);

/// coarse, noisy, edge, close_modes and may_be_two of a set in ascending order.
void flag_modes(std::vector<Mode>& modes, double line_spacing_hz, double leakage_hz, double band_lo_hz,
                double band_hi_hz);

}  // namespace struna::ident
