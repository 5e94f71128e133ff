#include "ident/rayleigh_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/SpecialFunctions>

#include "fem/error.hpp"
#include "ident/least_squares.hpp"

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

/// All damping read as stiffness-proportional: what one frequency can tell.
RayleighFit fit_stiffness_part_alone(const Eigen::MatrixX2d& a, const Eigen::VectorXd& b) {
  RayleighFit fit;
  fit.rayleigh.beta = a.col(1).dot(b) / a.col(1).squaredNorm();
  if (b.size() > 1) {
    fit.rms = (a.col(1) * fit.rayleigh.beta - b).norm() / std::sqrt(static_cast<double>(b.size() - 1));
  }
  fit.beta_sigma = std::max(1.0, fit.rms) / a.col(1).norm();
  fit.alpha_sigma = std::numeric_limits<double>::infinity();
  return fit;
}

double misfit(const Eigen::MatrixX2d& weighted, const Eigen::VectorXd& b, const fem::Rayleigh& rayleigh,
              int freedom) {
  if (freedom < 1) return 0.0;
  const Eigen::ArrayXd told = weighted * Eigen::Vector2d(rayleigh.alpha, rayleigh.beta);
  const double off = (told / b.array() - 1.0).square().sum() / static_cast<double>(freedom);
  const double noise = b.array().square().inverse().mean();  // b is the ratio over its sigma
  return std::sqrt(std::max(0.0, off - noise));
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
  LeastSquares problem;
  problem.residual = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return a * x - b; };
  problem.jacobian = [&](const Eigen::VectorXd&) -> Eigen::MatrixXd { return a; };
  problem.start = a.colPivHouseholderQr().solve(b);
  problem.lower = Eigen::Vector2d::Zero();
  problem.upper = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  const LeastSquaresSolution solution = solve_least_squares(problem);

  RayleighFit fit;
  fit.determined = true;
  fit.rayleigh = {solution.x[0] / scale[0], solution.x[1] / scale[1]};
  fit.alpha_at_bound = solution.at_bound[0];
  fit.beta_at_bound = solution.at_bound[1];
  fit.rms = solution.rms();
  const int freedom = solution.degrees_of_freedom();  // a bound that holds gives one back
  fit.misfit = misfit(weighted, b, fit.rayleigh, freedom);
  if (freedom > 0)
    fit.chance = Eigen::numext::igammac(0.5 * freedom, 0.5 * freedom * fit.rms * fit.rms);  // chi-square
  const Eigen::Vector2d error = std::max(1.0, fit.rms) * solution.covariance.diagonal().cwiseSqrt();
  fit.alpha_sigma = error[0] / scale[0];
  fit.beta_sigma = error[1] / scale[1];
  fit.covariance = std::pow(std::max(1.0, fit.rms), 2.0) * solution.covariance(0, 1) / (scale[0] * scale[1]);
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
