#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace struna::ident {

/// Small dense least squares: min |r(x)|^2/2, lower <= x <= upper.
struct LeastSquares {
  std::function<Eigen::VectorXd(const Eigen::VectorXd& x)> residual;
  /// residuals x parameters; empty: central differences.
  std::function<Eigen::MatrixXd(const Eigen::VectorXd& x)> jacobian;
  Eigen::VectorXd start;
  Eigen::VectorXd lower;  ///< infinite where there is none
  Eigen::VectorXd upper;
};

struct LeastSquaresSolution {
  Eigen::VectorXd x;
  Eigen::VectorXd residual;
  Eigen::MatrixXd covariance;  ///< (J^T J)^-1 of the parameters that no bound holds; zero rows for held ones
  std::vector<bool> at_bound;
  bool determined =
      false;  ///< J has full rank in the parameters that no bound holds; else the covariance is infinite
  bool converged = false;

  /// Residuals less the parameters that no bound holds.
  int degrees_of_freedom() const;
  /// Root of the mean square residual per degree of freedom, 0 without any.
  double rms() const;
};

/// Solves with Ceres (Levenberg-Marquardt, dense QR) to rounding. Ceres projects its steps onto the bounds
/// and can stall there before the rest has settled: what it put on a bound is held, and the rest is solved
/// again.
LeastSquaresSolution solve_least_squares(const LeastSquares& problem);

}  // namespace struna::ident
