#include "fem/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

constexpr double pi = std::numbers::pi;

Excitation excitation(Excitation::Kind kind) {
  Excitation e;
  e.kind = kind;
  e.band_lo_hz = 10.0;
  e.band_hi_hz = 1000.0;
  e.frequency_hz = 200.0;
  e.acceleration = 100.0;
  e.rms_acceleration = 20.0;
  e.seed = 7;
  return e;
}

const Excitation::Kind generated[] = {Excitation::Kind::sine, Excitation::Kind::chirp,
                                      Excitation::Kind::multisine, Excitation::Kind::random};

/// Largest |numerical - given| of velocity and acceleration over their largest values, by central differences
/// of order six of the displacement and of the velocity.
double derivative_error(const MotionHistory& motion, double h) {
  double velocity_error = 0.0, acceleration_error = 0.0, velocity = 0.0, acceleration = 0.0;
  const auto slope = [&](double t, auto pick) {
    return (45.0 * (pick(t + h) - pick(t - h)) - 9.0 * (pick(t + 2 * h) - pick(t - 2 * h)) +
            (pick(t + 3 * h) - pick(t - 3 * h))) /
           (60.0 * h);
  };
  for (int i = 0; i < 400; ++i) {
    const double t = 4.0 * h + (motion.duration() - 8.0 * h) * (i + 0.5) / 400.0;
    const auto sample = motion.at(t);
    const double v = slope(t, [&](double s) { return motion.at(s).displacement; });
    const double a = slope(t, [&](double s) { return motion.at(s).velocity; });
    velocity_error = std::max(velocity_error, std::abs(v - sample.velocity));
    acceleration_error = std::max(acceleration_error, std::abs(a - sample.acceleration));
    velocity = std::max(velocity, std::abs(sample.velocity));
    acceleration = std::max(acceleration, std::abs(sample.acceleration));
  }
  return std::max(velocity_error / velocity, acceleration_error / acceleration);
}

TEST(Motion, VelocityAndAccelerationAreTheDerivativesOfTheDisplacement) {
  for (const auto kind : generated) {
    const auto motion = motion_history(excitation(kind), 0.5);
    // Central differences of order six at 1000 Hz: (w h)^6/140 = 4e-10; rounding eps x/(h v) about as much.
    EXPECT_LT(derivative_error(motion, 5e-6), 1e-8) << static_cast<int>(kind);
  }
}

TEST(Motion, SineAndChirpStartAsTheirFormulasSay) {
  const auto sine = motion_history(excitation(Excitation::Kind::sine), 1.0);
  const double w = 2.0 * pi * 200.0;
  EXPECT_NEAR(sine.at(0.3e-3).displacement, -100.0 / (w * w) * std::sin(w * 0.3e-3), 1e-18);
  EXPECT_NEAR(sine.at(0.3e-3).acceleration, 100.0 * std::sin(w * 0.3e-3), 1e-12);  // rounding
  const auto chirp = motion_history(excitation(Excitation::Kind::chirp), 4.0);
  EXPECT_DOUBLE_EQ(chirp.at(0.0).displacement, 0.0);
  EXPECT_NEAR(chirp.at(0.0).velocity, -100.0 / (2.0 * pi * 10.0),
              1e-12);  // -1.6 m/s, physics of a chirp's start
  // Phase at the end is 2 pi (10 + 1000)/2 * 4 s, a whole number of turns: the displacement is back at zero.
  EXPECT_NEAR(chirp.at(4.0).displacement, 0.0, 1e-15);
}

TEST(Motion, RmsAccelerationIsExact) {
  const double duration = 1.0;
  const auto rms_from = [&](const MotionHistory& motion, double from) {
    const int count =
        200000;  // the trapezoidal rule is exact over a period, and within 1/(2 count) otherwise
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
      sum += std::pow(motion.at(from + (duration - from) * i / count).acceleration, 2);
    }
    return std::sqrt(sum / count);
  };
  const auto multisine = motion_history(excitation(Excitation::Kind::multisine), duration);
  EXPECT_NEAR(rms_from(multisine, multisine_period(duration)), 20.0, 20.0 * 1e-8);  // septic's error
  const auto random = motion_history(excitation(Excitation::Kind::random), duration);
  EXPECT_NEAR(rms_from(random, 0.0), 20.0,
              20.0 * 1e-3);  // the last node interval is counted in part: 1/24000
}

TEST(Motion, MultisineRepeatsAfterItsPeriodAndRandomDoesNot) {
  const auto multisine = motion_history(excitation(Excitation::Kind::multisine), 1.0);
  const auto random = motion_history(excitation(Excitation::Kind::random), 1.0);
  double same = 0.0, power = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.5 * i / 1000.0;
    // Rounding of t + period by the table's index.
    EXPECT_NEAR(multisine.at(t).displacement, multisine.at(t + 0.5).displacement, 1e-12);
    same += random.at(t).acceleration * random.at(t + 0.5).acceleration;
    power += std::pow(random.at(t).acceleration, 2);
  }
  // White over 990 Hz: correlation of two stretches of 0.5 s is 1/sqrt(2 B T) = 0.03; five sigma.
  EXPECT_LT(std::abs(same / power), 0.16);
}

/// Amplitude of the line at f over [from, to] in the acceleration.
double line_amplitude(const MotionHistory& motion, double f, double from, double to) {
  const int count = 20000;
  double c = 0.0, s = 0.0;
  for (int i = 0; i < count; ++i) {
    const double t = from + (to - from) * i / count;
    const double a = motion.at(t).acceleration;
    c += a * std::cos(2.0 * pi * f * t);
    s += a * std::sin(2.0 * pi * f * t);
  }
  return 2.0 * std::hypot(c, s) / count;
}

TEST(Motion, MultisineLinesHaveEqualAccelerationInsideTheBandAndNoneOutside) {
  const auto motion = motion_history(excitation(Excitation::Kind::multisine), 1.0);  // lines every 2 Hz
  const double each = 20.0 * std::sqrt(2.0 / 496.0);                                 // 10, 12 .. 1000 Hz
  for (const double f : {10.0, 12.0, 500.0, 998.0, 1000.0}) {
    EXPECT_NEAR(line_amplitude(motion, f, 0.5, 1.0), each, 1e-7 * each) << f;  // septic's error
  }
  for (const double f : {8.0, 1002.0, 1500.0})
    EXPECT_LT(line_amplitude(motion, f, 0.5, 1.0), 1e-7 * each) << f;
}

TEST(Motion, RandomIsGaussian) {
  auto e = excitation(Excitation::Kind::random);
  const auto motion = motion_history(e, 20.0);
  double second = 0.0, fourth = 0.0;
  const int count = 40000;
  for (int i = 0; i < count; ++i) {
    const double a = motion.at(20.0 * i / count).acceleration;
    second += a * a / count;
    fourth += a * a * a * a / count;
  }
  // Kurtosis 3 with standard deviation sqrt(24/n), n about the 4e4 nearly independent samples of 2 kHz: 5
  // sigma.
  EXPECT_NEAR(fourth / (second * second), 3.0, 5.0 * std::sqrt(24.0 / count));
}

TEST(Motion, SeedDecidesTheMotion) {
  auto e = excitation(Excitation::Kind::random);
  const double first = motion_history(e, 1.0).at(0.123).acceleration;
  EXPECT_EQ(motion_history(e, 1.0).at(0.123).acceleration, first);
  e.seed = 8;
  EXPECT_NE(motion_history(e, 1.0).at(0.123).acceleration, first);
}

/// A sine of unit amplitude about a mean that must be kept.
Eigen::VectorXd sine_samples(double f, double interval, int count) {
  Eigen::VectorXd samples(count);
  for (int i = 0; i < count; ++i) samples[i] = 1e-3 + std::sin(2.0 * pi * f * interval * i);
  return samples;
}

TEST(Motion, RecordPassesThroughItsSamplesAndKeepsItsMean) {
  const auto samples = sine_samples(170.0, 1e-3, 40);
  const auto motion = motion_from_samples(samples, 1e-3);
  EXPECT_DOUBLE_EQ(motion.duration(), 0.039);
  for (int i = 0; i < 40; ++i) EXPECT_NEAR(motion.at(1e-3 * i).displacement, samples[i], 1e-14) << i;
}

TEST(Motion, RecordConvergesAtEighthOrder) {
  const auto error = [](int per_period) {
    const double interval = 1.0 / (100.0 * per_period);
    const int count = 20 * per_period;
    const auto motion = motion_from_samples(sine_samples(100.0, interval, count), interval);
    double worst = 0.0;
    for (int i = 0; i < 997; ++i) {
      const double t = motion.duration() * (0.4 + 0.2 * i / 997.0);  // away from the ends
      worst = std::max(worst, std::abs(motion.at(t).displacement - 1e-3 - std::sin(2.0 * pi * 100.0 * t)));
    }
    return worst;
  };
  const double order = std::log2(error(16) / error(32));
  EXPECT_NEAR(order, 8.0, 0.3);  // spline of degree 7; next term of the expansion
}

TEST(Motion, RecordIsSmoothAcrossSamples) {
  const auto motion = motion_from_samples(sine_samples(170.0, 1e-3, 40), 1e-3);
  for (int i = 1; i < 39; ++i) {
    const auto left = motion.at(1e-3 * (i - 1e-9));
    const auto right = motion.at(1e-3 * (i + 1e-9));
    EXPECT_NEAR(left.acceleration, right.acceleration, 1e-2);  // jerk (1e9 m/s^3) times 2e-12 s
  }
}

TEST(Motion, RefusesWhatItCannotDo) {
  using Change = std::function<void(Excitation&)>;
  const std::vector<std::pair<Excitation::Kind, Change>> faults = {
      {Excitation::Kind::sine, [](Excitation& e) { e.frequency_hz = 0.0; }},
      {Excitation::Kind::sine, [](Excitation& e) { e.acceleration = -1.0; }},
      {Excitation::Kind::chirp, [](Excitation& e) { e.band_lo_hz = 0.0; }},
      {Excitation::Kind::chirp, [](Excitation& e) { e.band_hi_hz = e.band_lo_hz; }},
      {Excitation::Kind::chirp, [](Excitation& e) { e.acceleration = std::nan(""); }},
      {Excitation::Kind::random, [](Excitation& e) { e.rms_acceleration = 0.0; }},
      {Excitation::Kind::random,
       [](Excitation& e) { e.band_hi_hz = std::numeric_limits<double>::infinity(); }},
      {Excitation::Kind::multisine, [](Excitation& e) { e.band_lo_hz = 10.1, e.band_hi_hz = 10.2; }},
      {Excitation::Kind::record, [](Excitation&) {}},
  };
  for (const auto& [kind, change] : faults) {
    auto e = excitation(kind);
    change(e);
    EXPECT_THROW(motion_history(e, 1.0), Error) << static_cast<int>(kind);
  }
  for (const auto kind : generated) EXPECT_THROW(motion_history(excitation(kind), 0.0), Error);
  EXPECT_THROW(motion_from_samples(Eigen::VectorXd::Zero(7), 1e-3), Error);
  EXPECT_THROW(motion_from_samples(Eigen::VectorXd::Zero(8), 0.0), Error);
  Eigen::VectorXd bad = Eigen::VectorXd::Zero(8);
  bad[3] = std::nan("");
  EXPECT_THROW(motion_from_samples(bad, 1e-3), Error);
  const auto motion = motion_from_samples(Eigen::VectorXd::Zero(8), 1e-3);
  EXPECT_THROW(motion.at(-1e-3), Error);
  EXPECT_THROW(motion.at(8e-3), Error);
}

}  // namespace
}  // namespace struna::fem
