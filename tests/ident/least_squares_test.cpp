#include "ident/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace struna::ident {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

LeastSquares unbounded(std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residual,
                       const Eigen::VectorXd& start) {
  LeastSquares problem;
  problem.residual = std::move(residual);
  problem.start = start;
  problem.lower = Eigen::VectorXd::Constant(start.size(), -infinity);
  problem.upper = Eigen::VectorXd::Constant(start.size(), infinity);
  return problem;
}

/// exp(-x0 t) + x1 t against samples at x = (0.7, 0.2).
Eigen::VectorXd decay_residual(const Eigen::VectorXd& x) {
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(20, 0.0, 4.0);
  return (-x[0] * t).exp() + x[1] * t - (-0.7 * t).exp() - 0.2 * t;
}

TEST(LeastSquares, FindsTheParametersOfExactData) {
  const LeastSquaresSolution solution =
      solve_least_squares(unbounded(decay_residual, Eigen::Vector2d(2.0, 0.0)));
  EXPECT_TRUE(solution.converged);
  EXPECT_NEAR(solution.x[0], 0.7, 1e-12);  // rounding: the residual vanishes at the solution
  EXPECT_NEAR(solution.x[1], 0.2, 1e-12);
  EXPECT_EQ(solution.degrees_of_freedom(), 18);
}

TEST(LeastSquares, CovarianceIsTheInverseOfTheNormalMatrix) {
  const LeastSquaresSolution solution =
      solve_least_squares(unbounded(decay_residual, Eigen::Vector2d(2.0, 0.0)));
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(20, 0.0, 4.0);
  const Eigen::ArrayXd j0 = -t * (-0.7 * t).exp();
  const double a = j0.square().sum(), b = (j0 * t).sum(), c = t.square().sum();
  // Central differences: h^2 f'''/6 with h = 6e-6.
  EXPECT_NEAR(solution.covariance(0, 0) / (c / (a * c - b * b)), 1.0, 1e-9);
  EXPECT_NEAR(solution.covariance(0, 1) / (-b / (a * c - b * b)), 1.0, 1e-9);
}

TEST(LeastSquares, HoldsAParameterAtItsBoundAndSettlesTheRest) {
  LeastSquares problem = unbounded(decay_residual, Eigen::Vector2d(1.5, 0.5));
  problem.lower[0] = 1.0;
  const LeastSquaresSolution solution = solve_least_squares(problem);
  EXPECT_EQ(solution.x[0], 1.0);
  EXPECT_TRUE(solution.at_bound[0]);
  EXPECT_FALSE(solution.at_bound[1]);
  const Eigen::ArrayXd t = Eigen::ArrayXd::LinSpaced(20, 0.0, 4.0);
  const double best =
      0.2 + (((-0.7 * t).exp() - (-t).exp()) * t).sum() / t.square().sum();  // linear in the other
  EXPECT_NEAR(solution.x[1], best, 1e-9);                                    // difference Jacobian
  EXPECT_EQ(solution.covariance(0, 0), 0.0);
  EXPECT_EQ(solution.degrees_of_freedom(), 19);
}

TEST(LeastSquares, SaysWhenTheDataDoNotDetermineTheParameters) {
  const auto sum_only = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(5, x[0] + x[1] - 1.0);
  };
  const LeastSquaresSolution solution = solve_least_squares(unbounded(sum_only, Eigen::Vector2d(0.0, 0.0)));
  EXPECT_FALSE(solution.determined);
  EXPECT_TRUE(std::isinf(solution.covariance(0, 0)));
  EXPECT_NEAR(solution.x.sum(), 1.0, 1e-9);  // difference Jacobian
}

}  // namespace
}  // namespace struna::ident
