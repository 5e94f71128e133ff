#include "ident/polynomial_roots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;

// c_1 ... c_n of the product of (y - root).
Eigen::VectorXcd coefficients_of(const std::vector<Complex>& roots) {
  std::vector<Complex> product = {1.0};
  for (const Complex root : roots) {
    product.emplace_back(0.0);
    for (std::size_t i = product.size() - 1; i > 0; --i) product[i] -= root * product[i - 1];
  }
  return Eigen::Map<const Eigen::VectorXcd>(product.data() + 1, static_cast<long>(roots.size()));
}

double farthest(const std::vector<Complex>& roots, const std::vector<Complex>& truth) {
  double worst = 0.0;
  for (const Complex root : truth) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Complex found : roots) nearest = std::min(nearest, std::abs(found - root));
    worst = std::max(worst, nearest);
  }
  return worst;
}

std::vector<Complex> around_circle(int count, double radius, double turn) {
  std::vector<Complex> points;
  for (int i = 0; i < count; ++i)
    points.push_back(std::polar(radius * (1.0 + 0.01 * i), turn + 2.0 * std::numbers::pi * i / count));
  return points;
}

TEST(PolynomialRoots, AreTheFactorsOfAProduct) {
  const std::vector<Complex> truth = around_circle(14, 0.9, 0.3);
  const std::vector<Complex> found = polynomial_roots(coefficients_of(truth), around_circle(14, 1.4, 0.1));
  ASSERT_EQ(found.size(), 14u);
  EXPECT_LT(farthest(found, truth), 1e-11);  // rounding of the coefficients
}

TEST(PolynomialRoots, OfADoubleRootHaveHalfTheDigits) {
  const std::vector<Complex> truth = {{1.2, 0.1}, {1.2, 0.1}, {-0.5, 0.3}};
  const std::vector<Complex> found = polynomial_roots(coefficients_of(truth), around_circle(3, 1.0, 0.2));
  ASSERT_EQ(found.size(), 3u);
  EXPECT_LT(farthest(found, truth), 1e-7);
  for (const Complex root : found)
    EXPECT_LT(std::min(std::abs(root - truth[0]), std::abs(root - truth[2])), 1e-6);
}

TEST(PolynomialRoots, ComeFromTheCompanionMatrixWhereStartsCoincide) {
  const std::vector<Complex> truth = around_circle(6, 1.1, 0.5);
  const std::vector<Complex> found =
      polynomial_roots(coefficients_of(truth), std::vector<Complex>(6, {1.0, 0.2}));
  ASSERT_EQ(found.size(), 6u);
  EXPECT_LT(farthest(found, truth), 1e-11);
}

TEST(PolynomialRoots, AreNoneOfAConstantOrOfWhatIsNoNumber) {
  EXPECT_TRUE(polynomial_roots(Eigen::VectorXcd(), {}).empty());
  const Eigen::VectorXcd wrong = Eigen::VectorXcd::Constant(1, std::nan(""));
  EXPECT_TRUE(polynomial_roots(wrong, {1.0}).empty());
}

TEST(PolynomialRoots, RefuseAnotherNumberOfStarts) {
  EXPECT_THROW(polynomial_roots(Eigen::VectorXcd::Ones(3), {1.0, 2.0}), Error);
}

}  // namespace
}  // namespace struna::ident
