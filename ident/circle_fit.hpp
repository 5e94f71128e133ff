#pragma once

#include "ident/mode.hpp"

namespace struna::ident {

struct CircleFitOptions {
  fem::Damping damping = fem::Damping::structural;
  bool linear_residual = false;
  bool sigma_known =
      true;  ///< false: sigma gives weights only (it was estimated), the scatter gives the noise
};

/// One mode by Nyquist circles, all outputs jointly, from the lines of `tf` (circle form) in [lo_hz, hi_hz].
///
/// Per output the algebraic circle (Taubin 1991), then the geometric circle weighted by sigma, then the whole
/// angle law tan(theta/2) = (1 - (f/f0)^2)/eta by weighted least squares. From there circle and angle law
/// together: maximum likelihood for normal noise (fit_poles), which shares f0 and eta among the outputs and
/// yields standard errors. The residual is a constant per output (it moves the circle's centre);
/// `linear_residual` adds a linear term. `start_hz` serves where the circles alone give no start. Without
/// sigma the lines' own scatter gives the noise. Flags: not_converged, poor_circle (the geometric circle's).
/// What the window cannot tell, a neighbour's tail or a second mode, judge_circles() sees (circle_check.hpp).
/// Throws Error with fewer than 4 lines in the window.
Mode fit_circle(const TransferFunction& circle_form_tf, double start_hz, double lo_hz, double hi_hz,
                const CircleFitOptions& options = {});

struct PlaneCircle {
  std::complex<double> centre;
  double radius = 0.0;
};

/// Algebraic circle through points z with weights w: least sum of w (|z - c|^2 - r^2)^2 over its mean
/// gradient (Taubin, IEEE PAMI 13 (1991) 1115; as in Chernov, Circular and Linear Regression, 2010,
/// sec. 5.9). At least 3 points.
PlaneCircle taubin_circle(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight);

/// Least sum of w (|z - c| - r)^2, from `start` (Ceres).
PlaneCircle geometric_circle(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight,
                             const PlaneCircle& start);

/// Sum of w (|z - c| - r)^2.
double circle_misfit(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight, const PlaneCircle& circle);

/// Root s0 of the angle law in s = f^2 (viscous: s = f): on a mode's circle the angle seen from the centre is
/// constant + 2 arg(s - s0), so Re s0 is the resonance and |Im s0| half the bandwidth, in s. Weighted linear
/// least squares of sin(phi/2)(1 + r s) = cos(phi/2)(p + q s), reweighted to errors in the angle; w as for
/// the circle, i.e. 1/sigma^2.
std::complex<double> angle_law_root(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight,
                                    const Eigen::VectorXd& s, const PlaneCircle& circle);

}  // namespace struna::ident
