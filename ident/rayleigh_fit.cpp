#include "ident/rayleigh_fit.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

void check(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& damping_ratio,
           const Eigen::VectorXd& sigma, const char* function) {
  if (damping_ratio.size() != frequency_hz.size() || sigma.size() != frequency_hz.size()) {
    throw Error(
        fmt::format("{}: frequency, damping ratio and sigma must have equal length, got {}, {} and {}",
                    function, frequency_hz.size(), damping_ratio.size(), sigma.size()));
  }
  if (frequency_hz.size() == 0) throw Error(fmt::format("{}: at least one mode, got none", function));
  for (Eigen::Index i = 0; i < frequency_hz.size(); ++i) {
    const bool positive = frequency_hz[i] > 0.0 && damping_ratio[i] > 0.0 && sigma[i] > 0.0;
    if (!positive || !std::isfinite(frequency_hz[i] + damping_ratio[i] + sigma[i])) {
      throw Error(fmt::format(
          "{}: frequency, damping ratio and sigma must be positive, got {} Hz, {} and {} for mode {}",
          function, frequency_hz[i], damping_ratio[i], sigma[i], i + 1));
    }
  }
}

/// Rows (1/(2 omega), omega/2): zeta = A (alpha, beta), eq. (11).
Eigen::MatrixX2d design_matrix(const Eigen::VectorXd& frequency_hz) {
  const Eigen::ArrayXd omega = 2.0 * std::numbers::pi * frequency_hz.array();
  Eigen::MatrixX2d a(frequency_hz.size(), 2);
  a.col(0) = 0.5 / omega;
  a.col(1) = 0.5 * omega;
  return a;
}

/// A x - b, x in two blocks of one, so that either can be held.
class LinearResiduals : public ceres::CostFunction {
 public:
  LinearResiduals(Eigen::MatrixX2d a, Eigen::VectorXd b) : a_(std::move(a)), b_(std::move(b)) {
    set_num_residuals(static_cast<int>(b_.size()));
    *mutable_parameter_block_sizes() = {1, 1};
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd>(residuals, b_.size()) = a_ * Eigen::Vector2d(*x[0], *x[1]) - b_;
    for (int k = 0; jacobians != nullptr && k < 2; ++k) {
      if (jacobians[k] != nullptr) Eigen::Map<Eigen::VectorXd>(jacobians[k], b_.size()) = a_.col(k);
    }
    return true;
  }

 private:
  Eigen::MatrixX2d a_;
  Eigen::VectorXd b_;
};

/// min |A x - b|, x >= 0, the columns of A of length one. Ceres projects its steps onto the bounds and stalls
/// there before the other coefficient has settled (seen: 1e-3 off): what it put on a bound is held, and the
/// rest solved again.
Eigen::Vector2d solve_bounded(const Eigen::MatrixX2d& a, const Eigen::VectorXd& b) {
  Eigen::Vector2d x = a.colPivHouseholderQr().solve(b).cwiseMax(0.0);
  ceres::Problem problem;
  problem.AddResidualBlock(new LinearResiduals(a, b), nullptr, &x[0], &x[1]);
  problem.SetParameterLowerBound(&x[0], 0, 0.0);
  problem.SetParameterLowerBound(&x[1], 0, 0.0);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 0.0;  // stop on the gradient or the step, near 1e-15 of the solution
  options.gradient_tolerance = 1e-15;
  options.parameter_tolerance = 1e-15;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (x.minCoeff() > 0.0) return x;
  for (double& coefficient : x) {
    if (coefficient <= 0.0) problem.SetParameterBlockConstant(&coefficient);
  }
  ceres::Solve(options, &problem, &summary);
  return x;
}

/// Standard deviations of the coefficients that no bound holds, from the covariance (A^T A)^-1 of those
/// alone.
Eigen::Vector2d standard_errors(const Eigen::MatrixX2d& a, bool first_held, bool second_held) {
  const Eigen::Matrix2d normal = a.transpose() * a;
  if (first_held && second_held) return Eigen::Vector2d::Zero();
  if (first_held) return {0.0, 1.0 / std::sqrt(normal(1, 1))};
  if (second_held) return {1.0 / std::sqrt(normal(0, 0)), 0.0};
  return normal.inverse().diagonal().cwiseSqrt();
}

double rms_per_degree_of_freedom(const Eigen::VectorXd& residual, int parameters) {
  const Eigen::Index freedom = residual.size() - parameters;
  return freedom > 0 ? std::sqrt(residual.squaredNorm() / static_cast<double>(freedom)) : 0.0;
}

/// All damping read as stiffness-proportional: what one frequency can tell.
RayleighFit fit_stiffness_part_alone(const Eigen::MatrixX2d& a, const Eigen::VectorXd& b) {
  RayleighFit fit;
  fit.rayleigh.beta = a.col(1).dot(b) / a.col(1).squaredNorm();
  fit.rms = rms_per_degree_of_freedom(a.col(1) * fit.rayleigh.beta - b, 1);
  fit.beta_sigma = std::max(1.0, fit.rms) / a.col(1).norm();
  fit.alpha_sigma = std::numeric_limits<double>::infinity();
  return fit;
}

}  // namespace

RayleighFit fit_rayleigh(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& damping_ratio,
                         const Eigen::VectorXd& damping_ratio_sigma) {
  check(frequency_hz, damping_ratio, damping_ratio_sigma, "fit_rayleigh");
  const Eigen::VectorXd weight = damping_ratio_sigma.cwiseInverse();
  const Eigen::MatrixX2d weighted = weight.asDiagonal() * design_matrix(frequency_hz);
  const Eigen::VectorXd b = weight.cwiseProduct(damping_ratio);
  // The columns are parallel when all frequencies are one.
  if (frequency_hz.maxCoeff() - frequency_hz.minCoeff() <= 1e-6 * frequency_hz.maxCoeff()) {
    return fit_stiffness_part_alone(weighted, b);
  }
  const Eigen::Vector2d scale = weighted.colwise().norm();
  const Eigen::MatrixX2d a = weighted * scale.cwiseInverse().asDiagonal();
  const Eigen::Vector2d x = solve_bounded(a, b);

  RayleighFit fit;
  fit.determined = true;
  fit.rayleigh = {x[0] / scale[0], x[1] / scale[1]};
  fit.alpha_at_bound = x[0] <= 0.0;
  fit.beta_at_bound = x[1] <= 0.0;
  fit.rms = rms_per_degree_of_freedom(a * x - b, 2 - fit.alpha_at_bound - fit.beta_at_bound);
  const Eigen::Vector2d error =
      std::max(1.0, fit.rms) * standard_errors(a, fit.alpha_at_bound, fit.beta_at_bound);
  fit.alpha_sigma = error[0] / scale[0];
  fit.beta_sigma = error[1] / scale[1];
  return fit;
}

fem::Rayleigh rayleigh_pseudo_inverse(const Eigen::VectorXd& frequency_hz,
                                      const Eigen::VectorXd& damping_ratio) {
  check(frequency_hz, damping_ratio, Eigen::VectorXd::Ones(frequency_hz.size()), "rayleigh_pseudo_inverse");
  const Eigen::MatrixX2d design = design_matrix(frequency_hz);
  const Eigen::Vector2d scale =
      design.colwise().norm();  // does not change the solution of a full-rank problem
  const Eigen::Vector2d x =
      (design * scale.cwiseInverse().asDiagonal()).completeOrthogonalDecomposition().solve(damping_ratio);
  return {x[0] / scale[0], x[1] / scale[1]};
}

}  // namespace struna::ident
