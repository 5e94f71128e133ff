#include "ident/circle_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "tests/ident/simulated_modes.hpp"

namespace struna::ident {
namespace {

using simulated::add_noise;
using simulated::function_of;
using simulated::SimulatedMode;

constexpr double f0 = 100.0;
constexpr double eta = 0.02;

/// A mode whose circle has diameter 1.
SimulatedMode unit_mode(double loss_factor = eta, fem::Damping damping = fem::Damping::structural) {
  const Pole pole{f0, loss_factor};
  return {pole, {pole_scale(pole, damping)}};
}

Eigen::VectorXd lines_around(double loss_factor, int count) {
  return Eigen::VectorXd::LinSpaced(count, f0 * (1 - loss_factor), f0 * (1 + loss_factor));
}

Mode fit(const TransferFunction& tf, const CircleFitOptions& options = {}) {
  return fit_circle(tf, f0, tf.frequency_hz(0), tf.frequency_hz(tf.lines() - 1), options);
}

TEST(CircleFit, FindsAnExactCircleExactly) {
  for (const double loss_factor : {0.002, 0.02, 0.1, 0.3}) {
    const auto tf = function_of({unit_mode(loss_factor)}, lines_around(loss_factor, 25),
                                FrfKind::apparent_mass, fem::Damping::structural, {{0.3, 0.2}});
    const Mode mode = fit(tf);
    // Stopping tolerance of the solver; nothing else is in the way.
    EXPECT_NEAR(mode.natural_frequency_hz, f0, 1e-7 * f0 * loss_factor);
    EXPECT_NEAR(mode.loss_factor, loss_factor, 1e-7 * loss_factor);
    EXPECT_NEAR(std::abs(mode.modal_constant(0) - unit_mode(loss_factor).constant[0]) /
                    std::abs(unit_mode(loss_factor).constant[0]),
                0.0, 1e-6);
    EXPECT_NEAR(mode.circles.at(0).radius, 0.5, 1e-6);
    EXPECT_NEAR(std::abs(mode.circles.at(0).centre - std::complex(0.3, -0.3)), 0.0, 1e-6);
  }
}

// 26 lines within a bandwidth either side: there the peers' circle with the whole angle law has a standard
// deviation of .62 % in eta and .30 % of the bandwidth in f (noise of 1 % of the diameter, complex).
TEST(CircleFit, MeetsThePeersBiasAndScatterOverFourHundredSeeds) {
  const int seeds = 400;
  const auto clean = function_of({unit_mode()}, lines_around(eta, 26), FrfKind::apparent_mass,
                                 fem::Damping::structural, {{0.3, 0.2}});
  Eigen::ArrayXd eta_error(seeds), f_error(seeds), eta_score(seeds);
  for (int seed = 0; seed < seeds; ++seed) {
    auto tf = clean;
    add_noise(tf, {0.01 / std::numbers::sqrt2}, static_cast<unsigned>(seed));
    const Mode mode = fit(tf);
    eta_error(seed) = mode.loss_factor / eta - 1.0;
    f_error(seed) = (mode.natural_frequency_hz - f0) / (eta * f0);
    eta_score(seed) = (mode.loss_factor - eta) / mode.loss_factor_sigma;
  }
  const auto deviation = [](const Eigen::ArrayXd& x) { return std::sqrt((x - x.mean()).square().mean()); };
  EXPECT_LT(std::abs(eta_error.mean()), 1e-3);
  EXPECT_LT(deviation(eta_error), 6.5e-3);
  EXPECT_LT(deviation(f_error), 3.5e-3);
  // The standard errors are true: 400 scores have an rms of 1 within 3 sigma (3/sqrt(800)), and 5 % for the
  // errors' own scatter, as they are enlarged where a seed's misfit is above 1.
  EXPECT_NEAR(std::sqrt(eta_score.square().mean()), 1.0, 0.16);
}

TEST(CircleFit, SharesThePoleAmongOutputs) {
  SimulatedMode mode = unit_mode();
  const auto scale = mode.constant[0];
  mode.constant = {scale, -0.5 * scale, std::complex(0.0, 0.3) * scale};
  auto tf = function_of({mode}, lines_around(eta, 26), FrfKind::apparent_mass, fem::Damping::structural,
                        {{0.3, 0.2}, {0.0, 0.0}, {-1.0, 2.0}});
  const double sigma = 0.01 / std::numbers::sqrt2;
  add_noise(tf, {sigma, sigma, sigma}, 7);
  const Mode all = fit(tf);
  tf.outputs.resize(1);
  const Mode one = fit(tf);
  ASSERT_EQ(all.circles.size(), 3u);
  // Information adds up by squared amplitude: 1 + 0.25 + 0.09.
  EXPECT_NEAR(one.loss_factor_sigma / all.loss_factor_sigma, std::sqrt(1.34),
              0.15);  // the misfit's share of sigma
  EXPECT_LT(std::abs(all.natural_frequency_hz - f0), 4.0 * all.natural_frequency_sigma);
}

// A mode's share of the apparent mass is omega^2 g/(omega_r^2 (1 + i eta) - omega^2): an exact circle and a
// constant. The same times omega^2, the dynamic stiffness, is no circle.
TEST(CircleFit, DynamicStiffnessWouldBiasTheLossFactor) {
  for (const auto& [loss_factor, bias] : {std::pair{0.05, 0.005}, std::pair{0.1, 0.019}}) {
    const std::complex<double> constant = -loss_factor / std::complex(1.0, loss_factor);
    auto tf = function_of({unit_mode(loss_factor)}, lines_around(loss_factor, 41), FrfKind::apparent_mass,
                          fem::Damping::structural, {constant});
    EXPECT_NEAR(fit(tf).loss_factor / loss_factor - 1.0, 0.0, 1e-6);  // the solver's tolerance
    for (auto& output : tf.outputs)
      output.value.array() *= -tf.frequency_hz.array().square().cast<std::complex<double>>();
    // The figures are rounded, and depend on the window a little.
    EXPECT_NEAR(fit(tf).loss_factor / loss_factor - 1.0, bias, 0.5 * bias);
  }
}

TEST(CircleFit, ViscousCircleIsThatOfTheMobility) {
  const Pole pole{f0, eta};
  const SimulatedMode mode{pole, {pole_scale(pole, fem::Damping::viscous)}};
  const auto tf = function_of({mode}, lines_around(eta, 31), FrfKind::mobility, fem::Damping::viscous);
  CircleFitOptions options;
  options.damping = fem::Damping::viscous;
  const Mode found = fit(tf, options);
  // The pole's mirror image at negative frequency is not constant over the window: eta/8 of the bandwidth.
  EXPECT_NEAR(found.natural_frequency_hz, f0, 2e-3 * eta * f0);
  EXPECT_NEAR(found.loss_factor, eta, 2e-3 * eta);
  EXPECT_NEAR(found.damping_ratio, 0.5 * found.loss_factor, 1e-12);
}

TEST(CircleFit, HalfPowerPointsLieAQuarterTurnFromResonance) {
  const auto tf = function_of({unit_mode()}, lines_around(eta, 25), FrfKind::apparent_mass);
  const Mode mode = fit(tf);
  const Circle& circle = mode.circles.at(0);
  const auto resonance = circle.at_resonance - circle.centre;
  for (const auto& point : {circle.at_lower_half_power, circle.at_upper_half_power}) {
    EXPECT_NEAR(std::abs(std::arg((point - circle.centre) / resonance)), std::numbers::pi / 2, 1e-6);
  }
  EXPECT_NEAR(half_power_loss_factor(mode.lower_half_power_hz, mode.upper_half_power_hz,
                                     mode.natural_frequency_hz, fem::Damping::structural),
              mode.loss_factor, 1e-12);  // rounding
}

TEST(CircleFit, TaubinsCircleIsExactOnACircle) {
  Eigen::VectorXcd z(7);
  for (int i = 0; i < 7; ++i)
    z(i) = std::complex(3.0, -2.0) + std::polar(0.25, 0.3 * i);  // an arc of 100 degrees
  const PlaneCircle circle = taubin_circle(z, Eigen::VectorXd::Ones(7));
  EXPECT_NEAR(std::abs(circle.centre - std::complex(3.0, -2.0)), 0.0, 1e-10);  // rounding over a short arc
  EXPECT_NEAR(circle.radius, 0.25, 1e-10);
}

TEST(CircleFit, FlagsWhatIsNoCircle) {
  auto tf = function_of({unit_mode()}, lines_around(eta, 41), FrfKind::apparent_mass);
  add_noise(tf, {1e-3}, 1);
  EXPECT_FALSE(fit(tf).has(ModeFlag::poor_circle));
  for (long i = 0; i < tf.lines(); ++i)
    tf.outputs[0].value(i) *= 1.0 + 0.3 * std::sin(0.9 * static_cast<double>(i));
  EXPECT_TRUE(fit(tf).has(ModeFlag::poor_circle));
}

TEST(CircleFit, RefusesTooFewLines) {
  const auto tf = function_of({unit_mode()}, lines_around(eta, 25), FrfKind::apparent_mass);
  EXPECT_THROW(fit_circle(tf, f0, 99.9, 100.1, {}), Error);
  EXPECT_THROW(fit_circle(tf, f0, 200.0, 300.0, {}), Error);
}

}  // namespace
}  // namespace struna::ident
