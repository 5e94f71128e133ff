#include "ident/channel_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace struna::ident {
namespace {

using std::numbers::pi;

ChannelWatch watched(const Eigen::VectorXd& samples, long block = 1000) {
  ChannelWatch watch;
  for (long i = 0; i < samples.size(); i += block)
    watch.add(samples.segment(i, std::min(block, samples.size() - i)));
  return watch;
}

Eigen::VectorXd noise(long size, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(random); });
}

/// As a converter writes it.
Eigen::VectorXd in_steps(const Eigen::VectorXd& samples, double step) {
  return step * (samples / step).array().round();
}

Eigen::VectorXd sine(long size, double periods) {
  return (Eigen::ArrayXd::LinSpaced(size, 0.0, static_cast<double>(size - 1)) * 2.0 * pi * periods /
          static_cast<double>(size))
      .sin();
}

/// Half a sine of `width` samples in a record of `size` at rest.
Eigen::VectorXd pulse(long size, long width) {
  Eigen::VectorXd samples = Eigen::VectorXd::Zero(size);
  samples.segment(size / 10, width) = sine(2 * width, 1.0).head(width);
  return samples;
}

TEST(ChannelWatch, ClippedSamplesAreCountedOnTheirSide) {
  const Eigen::VectorXd x = noise(20000, 3);
  const Eigen::VectorXd clipped = x.cwiseMin(2.0).cwiseMax(-3.0);
  const ChannelWatch watch = watched(clipped);
  EXPECT_EQ(watch.at_upper_limit(), (x.array() >= 2.0).count());
  EXPECT_EQ(watch.at_lower_limit(), (x.array() <= -3.0).count());
  EXPECT_EQ(watch.upper(), 2.0);
  EXPECT_EQ(watch.lower(), -3.0);
}

TEST(ChannelWatch, ClippingIsFoundInConverterStepsAndInHits) {
  EXPECT_GT(watched(in_steps(noise(20000, 4), 0.01).cwiseMin(2.5)).at_upper_limit(), 50);
  EXPECT_GT(watched(in_steps(sine(20000, 7.3), 0.001).cwiseMin(0.95)).at_upper_limit(), 500);
  EXPECT_GT(watched(pulse(4000, 40).cwiseMin(0.8)).at_upper_limit(), 10);
}

TEST(ChannelWatch, SoundSignalsAreNotCalledClipped) {
  for (const double step : {0.3, 0.1, 0.03, 1e-2, 1e-3, 1e-6}) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      const ChannelWatch watch = watched(in_steps(noise(20000, seed), step));
      EXPECT_EQ(watch.at_upper_limit(), 0) << step << " " << seed;
      EXPECT_EQ(watch.at_lower_limit(), 0) << step << " " << seed;
    }
    for (const double periods : {1.0, 7.3, 311.7}) {
      const ChannelWatch watch = watched(in_steps((1.0 - 0.2 * step) * sine(20000, periods), step));
      EXPECT_EQ(watch.at_upper_limit(), 0) << step << " " << periods;
      EXPECT_EQ(watch.at_lower_limit(), 0) << step << " " << periods;
    }
  }
  const ChannelWatch hit = watched((pulse(4000, 40).array() - 0.01).matrix());
  EXPECT_EQ(hit.at_upper_limit(), 0);
  EXPECT_EQ(hit.at_lower_limit(), 0);  // it rests there
  EXPECT_EQ(watched(Eigen::VectorXd::Constant(100, 3.0)).at_upper_limit(), 0);
}

TEST(ChannelWatch, ActiveShareHasItsClosedForms) {
  // A statistic over 2e5 samples of noise scatters by sqrt(8/(3 N)) = 0.4 %; the others by rounding.
  EXPECT_NEAR(watched(noise(200000, 5)).active_share(), 1.0 / 3.0, 0.02 / 3.0);
  EXPECT_NEAR(watched(sine(20000, 50.0)).active_share(), 2.0 / 3.0, 1e-12);
  // The mean of a short pulse is taken out, which changes the share by its own square at most.
  EXPECT_NEAR(watched(pulse(100000, 500)).active_share(), 2.0 / 3.0 * 0.005, 3e-5);
  EXPECT_EQ(watched(Eigen::VectorXd::Constant(100, 3.0)).active_share(), 0.0);
}

TEST(ChannelWatch, OneSidednessTellsAHitFromASweep) {
  // A half-sine: (4/(3 pi))^2 / (1/2 * 3/8), less by the share of the record for the mean taken out.
  const double half_sine = std::pow(4.0 / (3.0 * pi), 2) / (0.5 * 0.375);
  EXPECT_NEAR(watched(pulse(100000, 500)).one_sidedness(), half_sine, 0.02);
  EXPECT_NEAR(watched(-pulse(100000, 500)).one_sidedness(), half_sine, 0.02);
  EXPECT_LT(watched(noise(200000, 5)).one_sidedness(), 1e-3);
  // Displacement of a sweep from 10 Hz to 1 kHz at constant acceleration: short, and of both signs.
  Eigen::VectorXd sweep(100000);
  for (long i = 0; i < sweep.size(); ++i) {
    const double t = 1e-4 * static_cast<double>(i);
    const double hertz = 10.0 + 99.0 * t;
    sweep[i] = std::sin(2.0 * pi * (10.0 * t + 49.5 * t * t)) / (hertz * hertz);
  }
  EXPECT_LT(watched(sweep).active_share(), 0.05);
  EXPECT_LT(watched(sweep).one_sidedness(), 0.5);  // its first half cycle is the largest
  EXPECT_EQ(watched(Eigen::VectorXd::Constant(100, 3.0)).one_sidedness(), 0.0);
}

TEST(ChannelWatch, NeitherOffsetNorBlocksMatter) {
  const Eigen::VectorXd x = noise(10000, 6).cwiseMin(2.0);
  const ChannelWatch plain = watched(x);
  const ChannelWatch other = watched((x.array() + 1000.0).matrix(), 7);
  EXPECT_EQ(other.at_upper_limit(), plain.at_upper_limit());
  // Rounding of the samples at 1000: 1e-13 relative to the noise.
  EXPECT_NEAR(other.active_share(), plain.active_share(), 1e-10);
}

}  // namespace
}  // namespace struna::ident
