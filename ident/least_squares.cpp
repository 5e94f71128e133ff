#include "ident/least_squares.hpp"

#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace struna::ident {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Central differences with a step of the cube root of the rounding unit, the best for them.
Eigen::MatrixXd difference_jacobian(const LeastSquares& problem, const Eigen::VectorXd& x) {
  Eigen::MatrixXd jacobian;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double step = 6e-6 * std::max(1.0, std::abs(x[k]));
    Eigen::VectorXd ahead = x, behind = x;
    ahead[k] += step;
    behind[k] -= step;
    const Eigen::VectorXd column =
        (problem.residual(ahead) - problem.residual(behind)) / (ahead[k] - behind[k]);
    if (k == 0) jacobian.resize(column.size(), x.size());
    jacobian.col(k) = column;
  }
  return jacobian;
}

Eigen::MatrixXd jacobian_at(const LeastSquares& problem, const Eigen::VectorXd& x) {
  return problem.jacobian ? problem.jacobian(x) : difference_jacobian(problem, x);
}

/// Every parameter is a block of one, so that each can be held by itself.
class Residuals : public ceres::CostFunction {
 public:
  Residuals(const LeastSquares& problem, int count) : problem_(problem) {
    set_num_residuals(count);
    mutable_parameter_block_sizes()->assign(static_cast<std::size_t>(problem.start.size()), 1);
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Eigen::VectorXd x(problem_.start.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) x[k] = *blocks[k];
    const Eigen::VectorXd r = problem_.residual(x);
    Eigen::Map<Eigen::VectorXd>(residuals, r.size()) = r;
    if (!r.allFinite()) return false;
    if (jacobians == nullptr) return true;
    const Eigen::MatrixXd jacobian = jacobian_at(problem_, x);
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      if (jacobians[k] != nullptr) Eigen::Map<Eigen::VectorXd>(jacobians[k], r.size()) = jacobian.col(k);
    }
    return jacobian.allFinite();
  }

 private:
  const LeastSquares& problem_;
};

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-30;  // stop on the gradient or the step, near rounding
  options.gradient_tolerance = 1e-15;
  options.parameter_tolerance = 1e-14;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  return options;
}

/// (J^T J)^-1 over the free parameters, columns scaled to one; a direction whose eigenvalue is lost in
/// rounding makes it infinite.
void set_covariance(const Eigen::MatrixXd& jacobian, LeastSquaresSolution& solution) {
  std::vector<Eigen::Index> free;
  for (std::size_t k = 0; k < solution.at_bound.size(); ++k) {
    if (!solution.at_bound[k]) free.push_back(static_cast<Eigen::Index>(k));
  }
  solution.covariance = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  solution.determined = true;
  if (free.empty()) return;
  const Eigen::MatrixXd columns = jacobian(Eigen::all, free);
  const Eigen::VectorXd scale = columns.colwise().norm();
  solution.determined = columns.rows() >= columns.cols() && scale.minCoeff() > 0.0;
  if (solution.determined) {
    const Eigen::MatrixXd scaled = columns * scale.cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() * scaled);
    solution.determined = eigen.eigenvalues().minCoeff() > 1e-13 * eigen.eigenvalues().maxCoeff();
    if (solution.determined) {
      const Eigen::MatrixXd vectors = scale.cwiseInverse().asDiagonal() * eigen.eigenvectors();
      solution.covariance(free, free) =
          vectors * eigen.eigenvalues().cwiseInverse().asDiagonal() * vectors.transpose();
    }
  }
  if (!solution.determined) {
    for (Eigen::Index k : free) solution.covariance(k, k) = infinity;
  }
}

}  // namespace

int LeastSquaresSolution::degrees_of_freedom() const {
  return static_cast<int>(residual.size() - std::count(at_bound.begin(), at_bound.end(), false));
}

double LeastSquaresSolution::rms() const {
  const int freedom = degrees_of_freedom();
  return freedom > 0 ? std::sqrt(residual.squaredNorm() / freedom) : 0.0;
}

LeastSquaresSolution solve_least_squares(const LeastSquares& problem) {
  LeastSquaresSolution solution;
  solution.x = problem.start.cwiseMax(problem.lower).cwiseMin(problem.upper);
  const auto parameters = static_cast<std::size_t>(solution.x.size());
  std::vector<double*> blocks;
  for (double& value : solution.x) blocks.push_back(&value);

  ceres::Problem ceres_problem;
  const int count = static_cast<int>(problem.residual(solution.x).size());
  ceres_problem.AddResidualBlock(new Residuals(problem, count), nullptr, blocks);
  for (std::size_t k = 0; k < parameters; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (problem.lower[i] > -infinity) ceres_problem.SetParameterLowerBound(blocks[k], 0, problem.lower[i]);
    if (problem.upper[i] < infinity) ceres_problem.SetParameterUpperBound(blocks[k], 0, problem.upper[i]);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(), &ceres_problem, &summary);
  solution.at_bound.assign(parameters, false);
  for (std::size_t k = 0; k < parameters; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    solution.at_bound[k] = solution.x[i] <= problem.lower[i] || solution.x[i] >= problem.upper[i];
    if (solution.at_bound[k]) ceres_problem.SetParameterBlockConstant(blocks[k]);
  }
  const auto held = std::count(solution.at_bound.begin(), solution.at_bound.end(), true);
  if (held > 0 && held < static_cast<long>(parameters))
    ceres::Solve(solver_options(), &ceres_problem, &summary);
  solution.converged = summary.termination_type == ceres::CONVERGENCE;
  solution.residual = problem.residual(solution.x);
  set_covariance(jacobian_at(problem, solution.x), solution);
  return solution;
}

}  // namespace struna::ident
