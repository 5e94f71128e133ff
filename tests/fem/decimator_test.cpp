#include "fem/decimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

double gain(const Eigen::VectorXd& tap, double cycles_per_sample) {
  const long half = tap.size() / 2;
  double sum = 0.0;
  for (long k = -half; k <= half; ++k) {
    sum += tap[k + half] * std::cos(2.0 * std::numbers::pi * cycles_per_sample * static_cast<double>(k));
  }
  return sum;
}

std::vector<Eigen::VectorXd> decimated(const std::vector<double>& samples, int factor) {
  Decimator decimator(factor);
  std::vector<Eigen::VectorXd> kept;
  for (const double x : samples) decimator.push(Eigen::VectorXd::Constant(1, x), kept);
  decimator.finish(kept);
  return kept;
}

TEST(Decimator, FilterKeepsItsPromise) {
  for (const int factor : {2, 3, 8, 20}) {
    const auto tap = anti_alias_filter(factor);
    for (double x = 0.0; x <= 0.4; x += 0.01)
      EXPECT_NEAR(gain(tap, x / factor), 1.0, 1e-4) << factor << ' ' << x;
    for (double x = 0.6; x <= 0.5 * factor; x += 0.01) {
      EXPECT_LT(std::abs(gain(tap, x / factor)), 1e-4) << factor << ' ' << x;
    }
  }
}

TEST(Decimator, KeepsLinesExactlyEverywhere) {
  for (const std::size_t count : {5U, 50U, 1000U}) {
    std::vector<double> samples;
    for (std::size_t i = 0; i < count; ++i) samples.push_back(3.0 - 0.25 * static_cast<double>(i));
    const auto kept = decimated(samples, 4);
    ASSERT_EQ(kept.size(), (count + 3) / 4);
    if (count < 1000) continue;  // shorter than the filter: reflected ends are held
    for (std::size_t n = 0; n < kept.size(); ++n) {
      // Point reflection continues a line as a line; rounding.
      EXPECT_NEAR(kept[n][0], samples[4 * n], 1e-11 * static_cast<double>(count)) << count << ' ' << n;
    }
  }
}

TEST(Decimator, PassesSlowSinesWithoutDelayAndStopsFastOnes) {
  std::vector<double> slow, fast;
  for (int i = 0; i < 4000; ++i) {
    slow.push_back(std::sin(2.0 * std::numbers::pi * 0.3 / 8.0 * i));
    fast.push_back(std::sin(2.0 * std::numbers::pi * 0.9 / 8.0 * i));
  }
  const auto kept_slow = decimated(slow, 8);
  const auto kept_fast = decimated(fast, 8);
  for (std::size_t n = 20; n < 480; ++n) {
    EXPECT_NEAR(kept_slow[n][0], slow[8 * n], 1e-4);  // ripple of the filter
    EXPECT_NEAR(kept_fast[n][0], 0.0, 1e-4);          // its stop band
  }
}

TEST(Decimator, FactorOneIsTheIdentity) {
  const auto kept = decimated({1.0, -2.0, 4.0}, 1);
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_EQ(kept[1][0], -2.0);
}

TEST(Decimator, RefusesWhatItCannotDo) {
  EXPECT_THROW(Decimator(0), Error);
  Decimator decimator(2);
  std::vector<Eigen::VectorXd> kept;
  decimator.push(Eigen::VectorXd::Ones(1), kept);
  decimator.finish(kept);
  EXPECT_THROW(decimator.push(Eigen::VectorXd::Ones(1), kept), Error);
}

}  // namespace
}  // namespace struna::fem
