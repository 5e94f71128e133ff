#include "ident/circle_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "ident/pole_fit.hpp"
#include "simulated_modes.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
using fem::Damping;
using simulated::add_noise;
using simulated::function_of;
using simulated::lines;
using simulated::SimulatedMode;

// A mode whose circle has diameter 1 in each output, at angles of its own.
SimulatedMode unit_mode(const Pole& pole, std::size_t outputs, Damping damping = Damping::structural) {
  SimulatedMode mode{pole, {}};
  for (std::size_t k = 0; k < outputs; ++k)
    mode.constant.push_back(std::polar(pole_scale(pole, damping), 0.7 + static_cast<double>(k)));
  return mode;
}

Eigen::VectorXcd arc(const PlaneCircle& circle, double from, double to, long n) {
  Eigen::VectorXcd z(n);
  for (long i = 0; i < n; ++i)
    z(i) = circle.centre +
           std::polar(circle.radius, from + (to - from) * static_cast<double>(i) / double(n - 1));
  return z;
}

TEST(CircleFit, ExactArcGivesItsCircle) {
  const PlaneCircle truth{{3.0, -2.0}, 0.5};
  const Eigen::VectorXd weight = Eigen::VectorXd::LinSpaced(12, 1.0, 3.0);
  const Eigen::VectorXcd z = arc(truth, 0.3, 2.0, 12);
  const PlaneCircle taubin = taubin_circle(z, weight);
  const PlaneCircle geometric = geometric_circle(z, weight, taubin);
  for (const PlaneCircle& circle : {taubin, geometric}) {
    EXPECT_NEAR(std::abs(circle.centre - truth.centre), 0.0, 1e-11);  // rounding, arc of a quarter turn
    EXPECT_NEAR(circle.radius, truth.radius, 1e-11);
  }
}

TEST(CircleFit, GeometricCircleIsLeastAmongItsNeighbours) {
  Eigen::VectorXcd z = arc({{1.0, 1.0}, 2.0}, 0.0, 3.0, 15);
  for (long i = 0; i < z.size(); ++i)
    z(i) += 0.1 * Complex(std::sin(7.0 * double(i)), std::cos(5.0 * double(i)));
  const Eigen::VectorXd weight = Eigen::VectorXd::LinSpaced(15, 0.5, 2.0);
  const PlaneCircle best = geometric_circle(z, weight, taubin_circle(z, weight));
  const double least = circle_misfit(z, weight, best);
  EXPECT_LE(least, circle_misfit(z, weight, taubin_circle(z, weight)));
  for (const double step : {-1e-3, 1e-3}) {
    EXPECT_GT(circle_misfit(z, weight, {best.centre + step, best.radius}), least);
    EXPECT_GT(circle_misfit(z, weight, {best.centre + Complex(0.0, step), best.radius}), least);
    EXPECT_GT(circle_misfit(z, weight, {best.centre, best.radius + step}), least);
  }
}

TEST(CircleFit, AngleLawGivesThePole) {
  const Pole pole{100.0, 0.03};
  const TransferFunction tf = function_of({unit_mode(pole, 1)}, lines(97.0, 103.0, 0.25), FrfKind::receptance,
                                          Damping::structural, {Complex(0.3, -0.2)});
  const Eigen::VectorXcd& z = tf.outputs[0].value;
  const Eigen::VectorXd weight = Eigen::VectorXd::Ones(z.size());
  const Complex root = angle_law_root(z, weight, tf.frequency_hz.cwiseAbs2(), taubin_circle(z, weight));
  EXPECT_NEAR(std::sqrt(root.real()), 100.0, 1e-9);
  EXPECT_NEAR(std::abs(root.imag()) / root.real(), 0.03, 1e-10);
}

TEST(CircleFit, NoiseFreeModeIsExactInEitherDamping) {
  for (const Damping damping : {Damping::structural, Damping::viscous}) {
    const Pole pole{100.0, 0.03};
    TransferFunction tf =
        function_of({unit_mode(pole, 2, damping)}, lines(96.0, 104.0, 0.25), FrfKind::receptance);
    for (auto& output : tf.outputs)  // without the mirror pole: one pole and a constant is what a circle is
      for (long i = 0; i < tf.lines(); ++i)
        output.value(i) =
            Complex(2.0, 1.0) + pole_scale(pole, damping) *
                                    pole_function(pole, 2.0 * std::numbers::pi * tf.frequency_hz(i), damping);
    CircleFitOptions options;
    options.damping = damping;
    const Mode mode = fit_circle(tf, 99.0, 96.0, 104.0, options);
    EXPECT_NEAR(mode.natural_frequency_hz, 100.0, 1e-8);
    EXPECT_NEAR(mode.loss_factor, 0.03, 1e-9);
    EXPECT_NEAR(mode.circles[0].radius, 0.5, 1e-8);
    const Complex top = 2.0 * (mode.circles[0].at_resonance - mode.circles[0].centre);
    const double off = damping == Damping::structural ? 1e-8 : 0.02;  // natural against damped frequency
    EXPECT_NEAR(std::abs(top), 1.0, off);
    // A quarter turn either side.
    const Complex lower = (mode.circles[0].at_lower_half_power - mode.circles[0].centre) / top * 2.0;
    const Complex upper = (mode.circles[0].at_upper_half_power - mode.circles[0].centre) / top * 2.0;
    EXPECT_NEAR(std::arg(lower), std::numbers::pi / 2.0, damping == Damping::structural ? 1e-7 : 0.04);
    EXPECT_NEAR(std::arg(upper), -std::numbers::pi / 2.0, damping == Damping::structural ? 1e-7 : 0.04);
  }
}

// One mode and a constant residual, 26 lines over a bandwidth either side, noise of 1 % of the diameter (its
// real and imaginary parts 1 %/sqrt 2 each). With so many lines an algebraic circle and the angle law alone
// reach .62 % and .30 %; the Cramer-Rao bound is .61 % and .31 %.
TEST(CircleFit, OneModeInNoiseIsUnbiasedAndAsGoodAsCanBe) {
  const Pole pole{100.0, 0.02};
  const double bandwidth = bandwidth_hz(pole);
  const TransferFunction clean =
      function_of({unit_mode(pole, 1)}, Eigen::VectorXd::LinSpaced(26, 100.0 - bandwidth, 100.0 + bandwidth),
                  FrfKind::apparent_mass, Damping::structural, {Complex(0.3, -0.2)});
  const int seeds = 400;
  double eta_sum = 0.0, eta_square = 0.0, f_sum = 0.0, f_square = 0.0, pull = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, {0.01 / std::numbers::sqrt2}, static_cast<unsigned>(seed));
    const Mode mode = fit_circle(tf, 100.0, 90.0, 110.0);
    const double eta = mode.loss_factor / pole.loss_factor - 1.0;
    const double f = (mode.natural_frequency_hz - 100.0) / bandwidth;
    eta_sum += eta;
    eta_square += eta * eta;
    f_sum += f;
    f_square += f * f;
    pull += std::pow(eta * pole.loss_factor / mode.loss_factor_sigma, 2.0);
  }
  const double eta_mean = eta_sum / seeds, f_mean = f_sum / seeds;
  EXPECT_LT(std::abs(eta_mean), 0.001);
  EXPECT_LT(std::sqrt(eta_square / seeds - eta_mean * eta_mean), 0.0065);
  EXPECT_LT(std::sqrt(f_square / seeds - f_mean * f_mean), 0.0035);
  // The standard errors tell the truth: chi-square of 400 has a scatter of 7 %; the enlarging by bad luck
  // adds some.
  EXPECT_NEAR(pull / seeds, 0.95, 0.25);
}

TEST(CircleFit, TwoBandwidthsAndThreePercentNoiseKeepTheLossFactorUnbiased) {
  const Pole pole{100.0, 0.02};
  const TransferFunction clean =
      function_of({unit_mode(pole, 1)}, Eigen::VectorXd::LinSpaced(49, 96.0, 104.0), FrfKind::apparent_mass,
                  Damping::structural, {Complex(0.3, -0.2)});
  double sum = 0.0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, {0.03 / std::numbers::sqrt2}, seed);
    sum += fit_circle(tf, 100.0, 90.0, 110.0).loss_factor / 0.02 - 1.0;
  }
  EXPECT_LT(std::abs(sum / 200.0),
            0.004);  // three standard errors of the mean; means over point pairs are 10 % low
}

// A mode's share of the stiffness form is omega^4 g_i g_j/(...): a circle plus omega^2 and a constant, and
// the slope of omega^2 biases a fit that knows a constant only. The apparent mass has the constant alone.
TEST(CircleFit, StiffnessFormBiasesTheLossFactorAndApparentMassDoesNot) {
  double bias[2];
  for (int i = 0; i < 2; ++i) {
    const Pole pole{100.0, i == 0 ? 0.05 : 0.10};
    const double half = bandwidth_hz(pole);
    TransferFunction stiffness =
        function_of({unit_mode(pole, 1)}, Eigen::VectorXd::LinSpaced(81, 100.0 - half, 100.0 + half),
                    FrfKind::dynamic_stiffness);
    for (long line = 0; line < stiffness.lines(); ++line)
      stiffness.outputs[0].value(line) *= -std::pow(stiffness.frequency_hz(line) / 100.0, 4.0);
    bias[i] = fit_circle(stiffness, 100.0, 1.0, 200.0).loss_factor / pole.loss_factor - 1.0;
    const TransferFunction mass = to_circle_form(stiffness, Damping::structural);
    EXPECT_EQ(mass.outputs[0].kind, FrfKind::apparent_mass);
    EXPECT_NEAR(fit_circle(mass, 100.0, 1.0, 200.0).loss_factor / pole.loss_factor, 1.0, 1e-7);
  }
  // Half a percent at 0.05 on a short arc, 0.9 % on this one; it grows with the square of the loss factor.
  EXPECT_GT(bias[0], 0.004);
  EXPECT_LT(bias[0], 0.012);
  EXPECT_NEAR(bias[1] / bias[0], 4.0, 0.4);
}

TEST(CircleFit, LinearResidualTakesOutASlope) {
  const Pole pole{100.0, 0.03};
  TransferFunction tf = function_of({unit_mode(pole, 1)}, lines(97.0, 103.0, 0.25), FrfKind::receptance);
  for (long i = 0; i < tf.lines(); ++i)
    tf.outputs[0].value(i) += 1e-4 * Complex(1.0, 2.0) * (tf.frequency_hz(i) * tf.frequency_hz(i) - 1e4);
  CircleFitOptions options;
  EXPECT_GT(std::abs(fit_circle(tf, 100.0, 97.0, 103.0, options).loss_factor - 0.03), 1e-5);
  options.linear_residual = true;
  EXPECT_NEAR(fit_circle(tf, 100.0, 97.0, 103.0, options).loss_factor, 0.03, 1e-9);
}

TEST(CircleFit, OutputsShareThePoleAndTheBestOnesRule) {
  const Pole pole{100.0, 0.02};
  const TransferFunction clean =
      function_of({unit_mode(pole, 2)}, lines(98.0, 102.0, 0.1), FrfKind::receptance);
  TransferFunction tf = clean;
  add_noise(tf, {0.001, 0.2}, 3);
  const Mode both = fit_circle(tf, 100.0, 98.0, 102.0);
  tf.outputs.pop_back();
  const Mode good = fit_circle(tf, 100.0, 98.0, 102.0);
  EXPECT_NEAR(both.loss_factor, good.loss_factor, 0.2 * good.loss_factor_sigma);
}

TEST(CircleFit, PoorCircleIsFlaggedAndASoundOneIsNot) {
  const Pole pole{100.0, 0.02};
  TransferFunction tf = function_of({unit_mode(pole, 1)}, lines(98.0, 102.0, 0.1), FrfKind::receptance);
  add_noise(tf, {0.002}, 1);
  EXPECT_FALSE(fit_circle(tf, 100.0, 98.0, 102.0).has(ModeFlag::poor_circle));
  for (long i = 0; i < tf.lines(); ++i)  // wobbles by 6 % of the radius, 15 times the noise
    tf.outputs[0].value(i) += 0.03 * std::polar(1.0, 2.0 * static_cast<double>(i));
  EXPECT_TRUE(fit_circle(tf, 100.0, 98.0, 102.0).has(ModeFlag::poor_circle));
}

TEST(CircleFit, RefusesTooFewLinesAndPoints) {
  const TransferFunction tf =
      function_of({unit_mode({100.0, 0.02}, 1)}, lines(98.0, 102.0, 0.1), FrfKind::receptance);
  EXPECT_THROW(fit_circle(tf, 100.0, 99.85, 100.15), Error);  // three lines
  EXPECT_NO_THROW(fit_circle(tf, 100.0, 99.75, 100.25));
  EXPECT_THROW(taubin_circle(Eigen::VectorXcd::Ones(2), Eigen::VectorXd::Ones(2)), Error);
  EXPECT_THROW(taubin_circle(Eigen::VectorXcd::Ones(5), Eigen::VectorXd::Ones(4)), Error);
}

}  // namespace
}  // namespace struna::ident
