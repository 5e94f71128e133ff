#pragma once

#include "ident/mode.hpp"

namespace struna::ident {

/// One mode by Nyquist circles, all outputs jointly, from the lines of `tf` (circle form) in [lo_hz, hi_hz].
///
/// Algebraic circle (Taubin 1991) per output, then the geometric circle weighted by sigma, then the whole angle law
/// tan(theta/2) = (1 - (f/f0)^2)/eta by weighted least squares, and from there circle and angle law together: maximum
/// likelihood for normal noise (Ceres), which shares f0 and eta among the outputs and yields standard errors.
/// The residual is a constant per output (it moves the circle's centre); `linear_residual` adds a linear term.
/// Throws Error with fewer than 4 lines in the window.
struct CircleFitOptions {
  fem::Damping damping = fem::Damping::structural;
  bool linear_residual = false;
};
Mode fit_circle(const TransferFunction& circle_form_tf, double start_hz, double lo_hz, double hi_hz,
                const CircleFitOptions& options = {});

/// Algebraic circle through points z with weights w (Taubin, IEEE PAMI 13 (1991) 1115).
struct AlgebraicCircle {
  std::complex<double> centre;
  double radius = 0.0;
};
AlgebraicCircle taubin_circle(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight);

}  // namespace struna::ident
