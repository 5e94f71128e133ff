#pragma once

#include <complex>

namespace struna::fem {

/// Straight uniform Euler-Bernoulli beam, clamped at both ends; the yardsticks of the tests. SI units.
struct ClampedBeam {
  double length = 0.0;
  double bending_stiffness = 0.0;  ///< E I [N m^2]
  double mass_per_length = 0.0;    ///< rho A [kg/m]
};

/// mode-th root (from 1) of cos x cosh x = 1 (Blevins, Formulas for Natural Frequency and Mode Shape, table
/// 8-1).
double clamped_clamped_root(int mode);
double natural_frequency_hz(const ClampedBeam& beam, int mode);

/// Support force over the transverse motion of one clamp, at the far and at the shaken support [N/m]:
/// -E I b^3 (sin x + sinh x)/(1 - cos x cosh x) and E I b^3 (cos x sinh x + sin x cosh x)/(1 - cos x cosh x),
/// x = b L, b^4 = rho A w^2/(E I (1 + i eta)).
std::complex<double> far_support_stiffness(const ClampedBeam& beam, double loss_factor, double f_hz);
std::complex<double> shaken_support_stiffness(const ClampedBeam& beam, double loss_factor, double f_hz);
/// Sum of both support forces over the common motion of both clamps [N/m], for complex stiffness scale (1 + i
/// eta) and mass scale (1 - i alpha/w).
std::complex<double> both_supports_stiffness(const ClampedBeam& beam, std::complex<double> stiffness_scale,
                                             std::complex<double> mass_scale, double f_hz);

}  // namespace struna::fem
