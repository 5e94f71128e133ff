// What Newmark's scheme makes of a vibration: its pole in closed form, against the stepper itself.
#include "fem/newmark_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace struna::fem {
namespace {

constexpr double omega = 100.0;  // [1/s]
constexpr double f_hz = omega / (2.0 * std::numbers::pi);

NewmarkOptions pair(double kappa, double lambda, double angle) {
  NewmarkOptions options;
  options.kappa = kappa;
  options.lambda = lambda;
  options.step = angle / omega;
  return options;
}

TEST(NewmarkError, PoleIsThatOfTheStepper) {
  // Two successive states of one oscillator span all later ones: x2 = 2 Re(z) x1 - |z|^2 x0, z = exp(pole
  // dt).
  for (const double zeta : {0.0, 0.03}) {
    for (const auto& options : {pair(0.25, 0.5, 0.3), pair(0.3025, 0.6, 0.3), pair(0.6, 0.9, 1.0)}) {
      NodalBody body;
      body.mass.lower = Eigen::MatrixXd::Constant(1, 1, 1.0);
      body.stiffness.lower = Eigen::MatrixXd::Constant(1, 1, omega * omega);
      body.rayleigh = {0.0, 2.0 * zeta / omega};
      body.load = Eigen::MatrixX3d::Zero(1, 3);
      NewmarkStepper stepper(
          {body}, {}, [](double) { return MotionSample{}; }, options);
      stepper.set_state(0, Eigen::VectorXd::Constant(1, 1.0), Eigen::VectorXd::Zero(1));
      double x[3];
      // The first steps hold the scheme's spurious root too, where it is not zero.
      for (int i = 0; i < 60; ++i) {
        stepper.advance((i + 1) * options.step);
        x[i % 3] = stepper.displacement(0)[0];
      }
      const std::complex<double> z = std::exp(newmark_pole(options, f_hz, zeta) * options.step);
      const double size = std::abs(x[0]) + std::abs(x[1]) + std::abs(x[2]);
      EXPECT_NEAR(x[2], 2.0 * z.real() * x[1] - std::norm(z) * x[0], 1e-10 * size)  // rounding of 60 steps
          << options.kappa << " " << options.lambda << " " << zeta;
    }
  }
}

TEST(NewmarkError, AverageAccelerationIsSlowAndAboveOneHalfIsDamped) {
  const double angle = 0.05;
  const auto slow = newmark_pole(pair(0.25, 0.5, angle), f_hz, 0.0);
  EXPECT_NEAR(slow.real(), 0.0, 1e-12 * omega);
  EXPECT_NEAR(1.0 - slow.imag() / omega, angle * angle / 12.0, std::pow(angle, 4));  // the next order
  const auto damped = newmark_pole(pair(0.3025, 0.6, angle), f_hz, 0.0);
  EXPECT_NEAR(-damped.real() / omega, 0.5 * 0.1 * angle, std::pow(angle, 3));
}

TEST(NewmarkError, GrowsWithTheStepSquaredAndWithDampingTakenAway) {
  const Rayleigh one_per_cent{0.0, 0.02 / omega};
  const auto error = [&](double kappa, double lambda, double angle, double duration) {
    return newmark_error(pair(kappa, lambda, angle), f_hz, one_per_cent, duration);
  };
  EXPECT_NEAR(error(0.25, 0.5, 0.1, 100.0) / error(0.25, 0.5, 0.05, 100.0), 4.0, 0.05);
  EXPECT_NEAR(error(0.3025, 0.6, 0.1, 100.0) / error(0.3025, 0.6, 0.05, 100.0), 2.0, 0.1);  // first order
  EXPECT_GT(error(0.3025, 0.6, 0.05, 100.0), error(0.25, 0.5, 0.05, 100.0));
  // A short run leaves a resonance no time to part.
  EXPECT_NEAR(error(0.25, 0.5, 0.05, 0.1) / error(0.25, 0.5, 0.05, 100.0), 0.1, 1e-9);
}

}  // namespace
}  // namespace struna::fem
