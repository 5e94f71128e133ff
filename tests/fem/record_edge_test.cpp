#include "fem/record_edge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "fem/error.hpp"
#include "fem/motion.hpp"

namespace struna::fem {
namespace {

constexpr double interval = 2e-4;
constexpr long count = 8000;
constexpr long reach = 10;

MotionHistory shaken() {
  Excitation excitation;
  excitation.kind = Excitation::Kind::random;
  excitation.band_lo_hz = 10.0;
  excitation.band_hi_hz = 1000.0;
  excitation.rms_acceleration = 20.0;
  excitation.seed = 3;
  return motion_history(excitation, interval * (count + 50));
}

Eigen::VectorXd truth(const MotionHistory& motion) {
  Eigen::VectorXd x(count);
  for (long i = 0; i < count; ++i) x[i] = motion.at(static_cast<double>(i) * interval).displacement;
  return x;
}

/// Resampled by 1:factor through a Kaiser (beta 5) windowed sinc with zeros before the start, as the common
/// resample functions do; only the first samples differ from the truth by more than the filter's ripple.
Eigen::VectorXd resampled(const MotionHistory& motion, int factor) {
  const long half = reach * factor;
  std::vector<double> taps;
  double sum = 0.0;
  for (long k = -half; k <= half; ++k) {
    const double x = static_cast<double>(k) / static_cast<double>(half);
    const double z = std::numbers::pi * static_cast<double>(k) / factor;
    taps.push_back(std::cyl_bessel_i(0.0, 5.0 * std::sqrt(1.0 - x * x)) * (k == 0 ? 1.0 : std::sin(z) / z));
    sum += taps.back();
  }
  Eigen::VectorXd y = truth(motion);
  for (long n = 0; n < 2 * reach; ++n) {
    y[n] = 0.0;
    for (long k = -half; k <= half; ++k) {
      const long fine = n * factor - k;
      if (fine < 0) continue;
      y[n] += taps[static_cast<std::size_t>(k + half)] / sum *
              motion.at(static_cast<double>(fine) * interval / factor).displacement;
    }
  }
  return y;
}

Eigen::VectorXd noisy(Eigen::VectorXd x, double sigma) {
  std::mt19937_64 draw(7);
  std::normal_distribution<double> normal(0.0, sigma);
  for (long i = 0; i < x.size(); ++i) x[i] += normal(draw);
  return x;
}

TEST(RecordEdge, FindsTheFactorAndTheMotionBeforeTheFilter) {
  const MotionHistory motion = shaken();
  const Eigen::VectorXd exact = truth(motion);
  const double noise = 25e-9;
  for (const int factor : {4, 10, 50, 200}) {
    const Eigen::VectorXd record = noisy(resampled(motion, factor), noise);
    // The edge is hundreds of times the noise.
    ASSERT_GT(std::abs(record[0] - exact[0]), 100.0 * noise);
    const auto edge = find_resampling_edge(record, interval);
    ASSERT_TRUE(edge.has_value()) << factor;
    EXPECT_EQ(edge->factor, factor);
    ASSERT_EQ(edge->repaired.size(), reach);
    // Noise through the reconstruction: 4 of the standard deviations that it tells; the record's spectrum is
    // itself an estimate.
    EXPECT_LT((edge->repaired - exact.head(reach)).cwiseAbs().maxCoeff(), 4.0 * edge->uncertainty) << factor;
    EXPECT_LT(edge->uncertainty, 10.0 * noise);
  }
}

TEST(RecordEdge, LeavesSoundRecordsAlone) {
  const MotionHistory motion = shaken();
  EXPECT_FALSE(find_resampling_edge(noisy(truth(motion), 25e-9), interval).has_value());
  EXPECT_FALSE(find_resampling_edge(Eigen::VectorXd::Zero(1000), interval).has_value());
  EXPECT_FALSE(find_resampling_edge(Eigen::VectorXd::Ones(100), interval).has_value());
}

TEST(RecordEdge, LeavesJumpsThatNoSuchFilterExplainsAlone) {
  Eigen::VectorXd x = noisy(truth(shaken()), 25e-9);
  x[0] += 1e-3;
  EXPECT_FALSE(find_resampling_edge(x, interval).has_value());
}

TEST(RecordEdge, MotionFromSamplesTakesItOutAndSaysSo) {
  const MotionHistory motion = shaken();
  const MotionHistory read = motion_from_samples(noisy(resampled(motion, 10), 25e-9), interval);
  EXPECT_NE(read.note().find("1:10"), std::string::npos) << read.note();
  EXPECT_NEAR(read.at(0.0).displacement, motion.at(0.0).displacement, 5e-7);  // 0.06 um told, and the noise
  EXPECT_TRUE(motion_from_samples(truth(motion), interval).note().empty());
}

}  // namespace
}  // namespace struna::fem
