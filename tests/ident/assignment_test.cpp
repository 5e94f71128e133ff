#include "ident/assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

double total(const Eigen::MatrixXd& cost, const std::vector<int>& column_of) {
  double sum = 0.0;
  for (std::size_t i = 0; i < column_of.size(); ++i) sum += cost(static_cast<Eigen::Index>(i), column_of[i]);
  return sum;
}

TEST(Assignment, IsTheCheapestOfAllPermutations) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-3.0, 5.0);
  for (int trial = 0; trial < 300; ++trial) {
    const int rows = 1 + trial % 5;
    const int columns = rows + trial % 3;
    Eigen::MatrixXd cost(rows, columns);
    for (double& c : cost.reshaped()) c = uniform(random);
    const std::vector<int> found = cheapest_assignment(cost);
    EXPECT_EQ(std::set<int>(found.begin(), found.end()).size(), found.size());

    std::vector<int> order(static_cast<std::size_t>(columns));
    std::iota(order.begin(), order.end(), 0);
    double best = 1e9;
    do {
      best = std::min(best, total(cost, {order.begin(), order.begin() + rows}));
    } while (std::next_permutation(order.begin(), order.end()));
    EXPECT_NEAR(total(cost, found), best, 1e-12);  // rounding
  }
}

TEST(Assignment, SwapsWhereOrderWouldBeDearer) {
  Eigen::MatrixXd cost(2, 2);
  cost << 5.0, 1.0, 1.0, 5.0;
  EXPECT_EQ(cheapest_assignment(cost), (std::vector<int>{1, 0}));
}

TEST(Assignment, RefusesMoreRowsThanColumnsAndInfiniteCosts) {
  EXPECT_THROW(cheapest_assignment(Eigen::MatrixXd::Zero(2, 1)), Error);
  EXPECT_THROW(cheapest_assignment(Eigen::MatrixXd::Constant(1, 1, 1.0 / 0.0)), Error);
  EXPECT_TRUE(cheapest_assignment(Eigen::MatrixXd::Zero(0, 3)).empty());
}

}  // namespace
}  // namespace struna::ident
