#include "fem/band_matrix.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <complex>
#include <random>

namespace struna::fem {
namespace {

BandMatrix random_band(int n, int half_bandwidth, unsigned seed, double diagonal) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BandMatrix a{Eigen::MatrixXd::Zero(half_bandwidth + 1, n)};
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k <= half_bandwidth && j + k < n; ++k)
      a.lower(k, j) = uniform(generator) + (k == 0 ? diagonal : 0.0);
  }
  return a;
}

TEST(BandMatrix, DenseAtAndProductAgree) {
  const BandMatrix a = random_band(17, 4, 1, 0.0);
  const Eigen::MatrixXd dense = a.dense();
  EXPECT_TRUE(dense.isApprox(dense.transpose()));
  for (int i = 0; i < 17; ++i) {
    for (int j = 0; j < 17; ++j) EXPECT_EQ(a.at(i, j), dense(i, j));
  }
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(17, 3);
  EXPECT_LT((multiply(a, x) - dense * x).norm(), 1e-14);  // rounding
}

TEST(BandMatrix, SparseProductIsTheProduct) {
  const BandMatrix a = random_band(17, 4, 5, 0.0);
  for (const std::vector<int>& entries : {std::vector<int>{0, 2}, {7, 9, 16}}) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(17);
    for (const int i : entries) x(i) = 0.3 + i;
    EXPECT_LT((multiply_sparse(a, x) - multiply(a, x)).norm(), 1e-14);  // rounding, another order of terms
  }
}

TEST(BandMatrix, SubmatrixPicksRowsAndColumns) {
  const BandMatrix a = random_band(12, 5, 2, 0.0);
  const std::vector<int> dof = {1, 2, 5, 6, 7, 11};
  EXPECT_TRUE(submatrix(a, dof).dense() == a.dense()(dof, dof));
}

class Solver : public ::testing::Test {
 protected:
  static constexpr int n = 40;
  using FourLanes = ComplexBandSolver<4>::Scales;
  BandMatrix stiffness = random_band(n, 11, 3, 8.0);
  BandMatrix mass = random_band(n, 11, 4, 4.0);

  /// Largest relative error over the lanes against Eigen's pivoted LU.
  template <std::size_t count>
  double error(const std::array<std::complex<double>, count>& s_k,
               const std::array<std::complex<double>, count>& s_m, bool refine) {
    constexpr int lanes = static_cast<int>(count);
    using Lanes = typename ComplexBandSolver<lanes>::Lanes;
    using Vectors = typename ComplexBandSolver<lanes>::Vectors;
    ComplexBandSolver<lanes> solver(stiffness, mass);
    EXPECT_EQ(solver.factorise(s_k, s_m), -1);
    Vectors b{Lanes::Random(lanes, n), Lanes::Random(lanes, n)};
    const Vectors right = b;
    solver.solve(b, refine);
    double worst = 0.0;
    for (int lane = 0; lane < lanes; ++lane) {
      const auto index = static_cast<std::size_t>(lane);
      const Eigen::MatrixXcd a = s_k[index] * stiffness.dense() + s_m[index] * mass.dense();
      const auto vector = [&](const Vectors& v) {
        Eigen::VectorXcd x(n);
        for (int i = 0; i < n; ++i) x(i) = {v.re(lane, i), v.im(lane, i)};
        return x;
      };
      const Eigen::VectorXcd reference = a.partialPivLu().solve(vector(right));
      worst = std::max(worst, (vector(b) - reference).norm() / reference.norm());
    }
    return worst;
  }
};

TEST_F(Solver, AgreesWithPivotedLuInEveryLane) {
  const FourLanes s_k = {{{1.0, 0.02}, {2.0, 0.1}, {0.5, 0.5}, {1.0, 1e-3}}};
  const FourLanes s_m = {{{-0.3, 0.0}, {-0.1, 0.4}, {-2.0, 0.0}, {1.0, 0.0}}};
  EXPECT_LT(error(s_k, s_m, false), 1e-12);  // rounding times the condition of these matrices
}

TEST_F(Solver, SolvesALoneFrequencyAsItDoesFour) {
  using OneLane = ComplexBandSolver<1>::Scales;
  EXPECT_LT(error(OneLane{{{1.0, 0.02}}}, OneLane{{{-0.3, 0.4}}}, false), 1e-12);  // as above
  const double shift = stiffness.at(0, 0) / mass.at(0, 0) * (1.0 + 1e-8);
  const double plain = error(OneLane{1.0}, OneLane{-shift}, false);
  EXPECT_GT(plain, 1e-10);
  EXPECT_LT(error(OneLane{1.0}, OneLane{-shift}, true), 1e-3 * plain);
}

TEST_F(Solver, RefinementKeepsAnUndampedIndefiniteSystemAccurate) {
  // The leading entry of K - s M nearly vanishes: a pivot of 1e-7 costs seven digits without refinement.
  const double shift = stiffness.at(0, 0) / mass.at(0, 0) * (1.0 + 1e-8);
  const FourLanes s_k = {{1.0, 1.0, 1.0, 1.0}};
  const FourLanes s_m = {{-shift, -shift, -0.2, -0.3}};
  const double plain = error(s_k, s_m, false);
  const double refined = error(s_k, s_m, true);
  EXPECT_GT(plain, 1e-10);
  EXPECT_LT(refined, 1e-3 * plain);
}

TEST_F(Solver, ReportsTheLaneWithAZeroPivot) {
  const BandMatrix identity{Eigen::MatrixXd::Ones(1, 5)};
  ComplexBandSolver<4> solver(identity, identity);
  EXPECT_EQ(solver.factorise({{1.0, 1.0, 1.0, 1.0}}, {{-0.5, -0.5, -1.0, -0.5}}), 2);
  EXPECT_EQ(solver.factorise({{1.0, 1.0, 1.0, 1.0}}, {{-0.5, -0.5, -2.0, -0.5}}), -1);
  ComplexBandSolver<1> alone(identity, identity);
  EXPECT_EQ(alone.factorise({1.0}, {-1.0}), 0);
}

}  // namespace
}  // namespace struna::fem
