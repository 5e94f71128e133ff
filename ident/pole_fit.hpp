#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/mode.hpp"
#include "ident/pole_columns.hpp"
#include "ident/resonance.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident {

struct PoleFitOptions {
  fem::Damping damping = fem::Damping::structural;
  ResidualTerms residual = ResidualTerms::band;
  bool conjugate_term = true;  ///< viscous only: the pole's mirror image at negative frequency
  bool sigma_known = true;     ///< false: sigma gives weights only, the scatter gives the noise
  int max_iterations = 100;
  double tolerance = 1e-3;  ///< standard errors that a last step may leave, about
};

struct PoleFit {
  std::vector<Pole> poles;         ///< in the order of the start values
  Eigen::MatrixXd covariance;      ///< of (f_1 [Hz], eta_1, f_2, eta_2, …)
  Eigen::MatrixXcd constant;       ///< C, poles x outputs
  Eigen::MatrixXd constant_sigma;  ///< of real and imaginary part
  Eigen::MatrixXcd fitted;         ///< lines x outputs
  Eigen::MatrixXcd residual;       ///< (data - fitted)/sigma, lines x outputs
  double chi_square = 0.0;         ///< sum of |residual|^2
  long degrees_of_freedom =
      0;  ///< real data less real parameters; chi_square is about this when the model holds
  double line_correlation =
      1.0;  ///< neighbouring lines that are worth one: 1 + 2 sum of the residual's autocorrelation
  bool converged = false;
  /// What one more step would move each pole, in standard errors, the larger of f and eta: beside a weak pole
  /// that wanders the others may have settled.
  Eigen::VectorXd unsettled;
};

/// `unsettled` from a step in (ln f_1, ln eta_1, ln f_2, …).
Eigen::VectorXd unsettled_by(const Eigen::VectorXd& step, const PoleFit& fit);

/// Common poles of all outputs by weighted separable least squares: at each step the constants and residual
/// terms, in which the model is linear, are eliminated exactly per output, and Levenberg-Marquardt moves only
/// ln f and ln eta with the projected Jacobian (Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; Kaufman,
/// BIT 15 (1975) 49, who drops the part of the derivative that is second order in the residual). Normal
/// equations give the step, the residual itself gives the gradient, so their squared condition number costs
/// iterations, not digits. Many lines are fitted in blocks (line_blocks.hpp) first. `tf` in circle form, each
/// output with sigma. Covariance: inverse of the projected Hessian, times line_correlation, times chi_square
/// per degree of freedom where that is above 1 or sigma is not known.
PoleFit fit_poles(const TransferFunction& tf, const std::vector<Pole>& start, const PoleFitOptions& options);

/// Pole r of a fit as a mode, without circles (their columns NaN); flag not_converged where the fit
/// did not converge and this pole would move by a tenth of its standard error or more.
Mode to_mode(const PoleFit& fit, long r, fem::Damping damping);

}  // namespace struna::ident
