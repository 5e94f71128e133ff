#include "ident/hit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

/// A half sine of 20 samples on an offset with noise.
Eigen::VectorXd pulse(long samples, long at, double amplitude, double offset, double noise) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(offset, noise);
  Eigen::VectorXd force(samples);
  for (double& value : force) value = noise > 0.0 ? normal(random) : offset;
  for (long i = 0; i < 20 && at + i < samples; ++i)
    force[at + i] += amplitude * std::sin(std::numbers::pi * (static_cast<double>(i) + 0.5) / 20.0);
  return force;
}

TEST(Hit, IsFoundWithinTwoSamplesForEitherSignAndAnyOffset) {
  for (const double sign : {1.0, -1.0}) {
    for (const double offset : {0.0, 30.0, -500.0}) {
      const Hit hit = find_hit(pulse(5000, 400, sign * 100.0, offset, 0.3));
      EXPECT_NEAR(static_cast<double>(hit.start), 400.0, 2.0);
      EXPECT_NEAR(static_cast<double>(hit.peak), 409.5, 2.0);
      EXPECT_FALSE(hit.second);
    }
  }
}

TEST(Hit, ASecondOneIsSeen) {
  const Eigen::VectorXd force = pulse(5000, 400, 100.0, 0.0, 0.1) + pulse(5000, 900, 25.0, 0.0, 0.1);
  EXPECT_TRUE(find_hit(force).second);
}

TEST(Hit, WithoutOneIsRefused) {
  EXPECT_THROW(find_hit(Eigen::VectorXd::Constant(100, 3.0)), Error);
}

TEST(Hit, RestIsTheMeanBeforeItOrTheMedian) {
  Eigen::MatrixXd samples(1000, 2);
  samples.col(0) = pulse(1000, 100, 50.0, 2.0, 0.0);
  samples.col(1) = samples.col(0).array() - 7.0;
  Eigen::RowVectorXd rest = rest_values(samples, find_hit(samples.col(0)));
  EXPECT_NEAR(rest[0], 2.0, 1e-12);
  EXPECT_NEAR(rest[1], -5.0, 1e-12);
  samples.col(0) = pulse(1000, 3, 50.0, 2.0, 0.0);
  samples.col(1) = samples.col(0).array() - 7.0;
  rest = rest_values(samples, find_hit(samples.col(0)));
  EXPECT_NEAR(rest[0], 2.0, 1e-12);
  EXPECT_NEAR(rest[1], -5.0, 1e-12);
}

}  // namespace
}  // namespace struna::ident
