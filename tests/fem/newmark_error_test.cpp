// What Newmark's scheme makes of a driven vibration, against the scheme's own transfer function.
#include "fem/newmark_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/fem/oscillators.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
using testing::oscillators;

constexpr double omega = 100.0;  // [1/s]
constexpr double f_hz = omega / (2.0 * std::numbers::pi);
constexpr double zeta = 0.01;
const Rayleigh one_per_cent{0.0, 2.0 * zeta / omega};

NewmarkOptions pair(double kappa, double lambda, double angle) {
  NewmarkOptions options;
  options.kappa = kappa;
  options.lambda = lambda;
  options.step = angle / omega;
  return options;
}

/// A vibration at 100 1/s that the base drives.
ModalBody shaken() {
  ModalBody body = oscillators({omega}, zeta);
  body.poles.natural_frequency_hz = Eigen::VectorXd::Constant(1, f_hz);
  body.load(0, 2) = -1.0;
  return body;
}

/// u'' = sin(ratio omega t).
PrescribedMotion base(double ratio) {
  const double w = ratio * omega;
  return [w](double t) {
    return MotionSample{-std::sin(w * t) / (w * w), -std::cos(w * t) / w, std::sin(w * t)};
  };
}

double error(const NewmarkOptions& options, double ratio, double duration) {
  return newmark_error(options, shaken(), one_per_cent, base(ratio), f_hz, duration);
}

/// Steady state under a sine: x'' = p/(1 + 2 zeta omega D1 + omega^2 D2), where a scheme that steps
/// z = exp(i w dt) makes x' = D1 x'' and x = D2 x''; the force is p - x''.
double steady_error(const NewmarkOptions& o, double ratio) {
  const Complex s(0.0, ratio * omega), z = std::exp(s * o.step);
  const Complex d1 = o.step * (1.0 - o.lambda + o.lambda * z) / (z - 1.0);
  const Complex d2 = o.step * (d1 + o.step * (0.5 - o.kappa + o.kappa * z)) / (z - 1.0);
  const auto force = [](Complex velocity, Complex displacement) {
    return 1.0 - 1.0 / (1.0 + 2.0 * zeta * omega * velocity + omega * omega * displacement);
  };
  const Complex exact = force(1.0 / s, 1.0 / (s * s));
  return std::abs(force(d1, d2) - exact) / std::abs(exact);
}

TEST(NewmarkError, IsThatOfTheSchemesTransferFunctionInSteadyState) {
  for (const auto& options : {pair(0.25, 0.5, 0.1), pair(0.3025, 0.6, 0.02), pair(0.6, 0.9, 0.005)}) {
    for (const double ratio : {0.97, 1.0}) {
      const double expected = steady_error(options, ratio);
      EXPECT_GT(expected, 0.01);
      // 100 decay times: the first few, while the vibration swells, make up some per cent.
      EXPECT_NEAR(error(options, ratio, 100.0), expected, 0.05 * expected) << options.kappa << " " << ratio;
    }
  }
}

TEST(NewmarkError, GrowsWithTheStepSquaredAndWithDampingTakenAway) {
  const auto at = [&](double kappa, double lambda, double angle) {
    return error(pair(kappa, lambda, angle), 1.0, 50.0);
  };
  EXPECT_NEAR(at(0.25, 0.5, 0.1) / at(0.25, 0.5, 0.05), 4.0, 0.1);
  EXPECT_NEAR(at(0.3025, 0.6, 0.01) / at(0.3025, 0.6, 0.005), 2.0, 0.1);  // first order
  EXPECT_GT(at(0.3025, 0.6, 0.05), at(0.25, 0.5, 0.05));
}

TEST(NewmarkError, DependsOnWhatTheMotionExcitesAndForHowLong) {
  const NewmarkOptions options = pair(0.25, 0.5, 0.1);
  EXPECT_LT(error(options, 0.3, 100.0), 0.1 * error(options, 1.0, 100.0));  // far from the resonance
  EXPECT_LT(error(options, 1.0, 0.2), 0.3 * error(options, 1.0, 100.0));    // no time to drift
}

TEST(NewmarkError, IsNothingWhereNothingDrives) {
  ModalBody body = shaken();
  body.load.setZero();
  EXPECT_EQ(newmark_error(pair(0.25, 0.5, 0.1), body, one_per_cent, base(1.0), f_hz, 1.0), 0.0);
}

TEST(NewmarkError, AForceDrivesAsASupportDoes) {
  ModalBody body = shaken();
  body.load.col(0) = -body.load.col(2);
  body.load.col(2).setZero();
  const NewmarkOptions options = pair(0.25, 0.5, 0.1);
  const auto force = [&](double t) {
    const MotionSample u = base(1.0)(t);
    return MotionSample{-u.acceleration, -omega * std::cos(omega * t), omega * omega * u.acceleration};
  };
  const double by_force = newmark_error(options, body, one_per_cent, force, f_hz, 100.0);
  EXPECT_NEAR(by_force, error(options, 1.0, 100.0),
              0.01 * by_force);  // the load's path within a step differs
}

}  // namespace
}  // namespace struna::fem
