#include "ident/mode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/error.hpp"
#include "ident/mode_flags.hpp"
#include "ident/resonance.hpp"
#include "simulated_modes.hpp"

namespace struna::ident {
namespace {

using fem::Damping;
using simulated::function_of;
using simulated::lines;

TEST(Mode, FlagsAreWordsAndBack) {
  for (const ModeFlag flag :
       {ModeFlag::coarse, ModeFlag::close_modes, ModeFlag::double_mode, ModeFlag::may_be_two, ModeFlag::noisy,
        ModeFlag::edge, ModeFlag::poor_circle, ModeFlag::not_converged})
    EXPECT_EQ(mode_flag(to_string(flag)), flag);
  EXPECT_THROW(mode_flag("fine"), Error);
}

TEST(Mode, CircleFormIsTheOneInWhichAModeIsACircle) {
  for (const FrfKind kind : {FrfKind::dynamic_stiffness, FrfKind::impedance, FrfKind::apparent_mass})
    for (const Damping damping : {Damping::structural, Damping::viscous})
      EXPECT_EQ(circle_form(kind, damping), FrfKind::apparent_mass);
  for (const FrfKind kind : {FrfKind::receptance, FrfKind::mobility, FrfKind::accelerance}) {
    EXPECT_EQ(circle_form(kind, Damping::structural), FrfKind::receptance);
    EXPECT_EQ(circle_form(kind, Damping::viscous), FrfKind::mobility);
  }
  for (const FrfKind kind : {FrfKind::transmissibility, FrfKind::unknown})
    EXPECT_EQ(circle_form(kind, Damping::structural), kind);
}

TEST(Mode, CircleFormConvertsAndLeavesOutTheLineAtZero) {
  const TransferFunction receptance =
      function_of({{{20.0, 0.02}, {3.0}}}, lines(0.0, 50.0, 0.5), FrfKind::receptance);
  const TransferFunction accelerance = convert(receptance, FrfKind::accelerance);
  const TransferFunction form = to_circle_form(accelerance, Damping::structural);
  EXPECT_EQ(form.outputs[0].kind, FrfKind::receptance);
  EXPECT_GT(form.frequency_hz(0), 0.0);
  const long n = form.lines();
  // To rounding: -omega^2 in and out.
  EXPECT_LT((form.outputs[0].value - receptance.outputs[0].value.tail(n)).norm(),
            1e-14 * form.outputs[0].value.norm());
}

TEST(Mode, OutputsOfTwoFamiliesAreRefused) {
  TransferFunction tf = function_of({{{20.0, 0.02}, {3.0, 1.0}}}, lines(1.0, 50.0, 0.5), FrfKind::receptance);
  tf.outputs[1].kind = FrfKind::dynamic_stiffness;
  EXPECT_THROW(to_circle_form(tf, Damping::structural), Error);
  tf.outputs.clear();
  EXPECT_THROW(to_circle_form(tf, Damping::structural), Error);
}

TEST(Resonance, HalfPowerPointsAreAQuarterTurnAndGiveTheLossFactorBack) {
  for (const Damping damping : {Damping::structural, Damping::viscous}) {
    const Pole pole{120.0, 0.08};
    const double lower = lower_half_power_hz(pole, damping), upper = upper_half_power_hz(pole, damping);
    EXPECT_NEAR(half_power_loss_factor(lower, upper, 120.0, damping), 0.08, 1e-14);
    // The mobility's half-power points lie zeta^2 off the circle's quarter turn.
    const double tolerance = damping == Damping::structural ? 1e-12 : 1.1 * 0.04;
    EXPECT_NEAR(angle_coordinate(pole, lower, damping), 1.0, tolerance);
    EXPECT_NEAR(angle_coordinate(pole, upper, damping), -1.0, tolerance);
  }
}

TEST(Resonance, PoleFunctionIsOneOverXPlusI) {
  for (const Damping damping : {Damping::structural, Damping::viscous})
    for (const double f : {80.0, 99.0, 100.0, 103.0}) {
      const Pole pole{100.0, 0.05};
      const std::complex<double> g = pole_function(pole, 2.0 * std::numbers::pi * f, damping);
      const std::complex<double> phase =
          damping == Damping::structural ? 1.0 : std::complex<double>(0.0, 1.0);
      const std::complex<double> x_plus_i{angle_coordinate(pole, f, damping), 1.0};
      EXPECT_NEAR(std::abs(g * pole_scale(pole, damping) * x_plus_i / phase - 1.0), 0.0, 1e-12);
    }
}

// A mode of f = 100 Hz and half-power band `band` with errors as given.
Mode mode_with(double band, double f_sigma = 0.0, double eta_sigma = 0.0, double f = 100.0) {
  Mode mode;
  mode.natural_frequency_hz = mode.circle_natural_frequency_hz = f;
  mode.loss_factor = band / f;
  mode.lower_half_power_hz = f - 0.5 * band;
  mode.upper_half_power_hz = f + 0.5 * band;
  mode.natural_frequency_sigma = f_sigma;
  mode.loss_factor_sigma = eta_sigma;
  return mode;
}

TEST(ModeFlags, CoarseBelowFourLineSpacingsWhereTheLeakageIsNotKnown) {
  EXPECT_TRUE(is_coarse(mode_with(0.99), 0.25, NAN));
  EXPECT_FALSE(is_coarse(mode_with(1.01), 0.25, NAN));
}

TEST(ModeFlags, CoarseWhereKnownLeakageLeavesMoreDoubtThanFivePercentAndThanNoise) {
  // 0.6 of what widens n lines by 0.7/n^2 is 5 % at n = 2.90, seen as 3.14.
  EXPECT_TRUE(is_coarse(mode_with(3.13), 0.25, 1.0));
  EXPECT_FALSE(is_coarse(mode_with(3.15), 0.25, 1.0));
  EXPECT_TRUE(is_coarse(mode_with(2.5, 0.0, 0.025 * 0.08), 0.25, 1.0));  // 0.6 of 15 %, known to 8 %
  EXPECT_FALSE(is_coarse(mode_with(2.5, 0.0, 0.025 * 0.10), 0.25, 1.0));
  EXPECT_TRUE(is_coarse(mode_with(2.5, NAN, NAN), 0.25, 1.0));  // no standard error, as of peak picking
}

TEST(ModeFlags, CoarseBetweenLinesWithNoiseWhereNothingLeaks) {
  EXPECT_TRUE(is_coarse(mode_with(0.59, 0.0, 0.0059 * 0.0031), 1.0, 0.0));
  EXPECT_FALSE(is_coarse(mode_with(0.59, 0.0, 0.0059 * 0.0029), 1.0, 0.0));
  EXPECT_FALSE(is_coarse(mode_with(0.61, 0.0, 0.0061 * 0.0031), 1.0, 0.0));
  EXPECT_TRUE(is_coarse(mode_with(0.59, NAN, NAN), 1.0, 0.0));
}

TEST(ModeFlags, NoisyAboveFivePercentOfTheBandwidthOrTenOfTheLossFactor) {
  EXPECT_TRUE(is_noisy(mode_with(2.0, 0.101)));
  EXPECT_FALSE(is_noisy(mode_with(2.0, 0.099)));
  EXPECT_TRUE(is_noisy(mode_with(2.0, 0.0, 0.00201)));
  EXPECT_FALSE(is_noisy(mode_with(2.0, 0.0, 0.00199)));
  EXPECT_FALSE(is_noisy(mode_with(2.0, NAN, NAN)));  // no standard errors, as of peak picking
}

TEST(ModeFlags, EdgeWhenTheHalfPowerBandReachesPastTheBand) {
  EXPECT_TRUE(reaches_edge(mode_with(2.0), 99.1, 200.0));
  EXPECT_TRUE(reaches_edge(mode_with(2.0), 50.0, 100.9));
  EXPECT_FALSE(reaches_edge(mode_with(2.0), 98.9, 101.1));
}

TEST(ModeFlags, CloseWithinTheLargerHalfPowerBand) {
  EXPECT_TRUE(are_close(mode_with(1.0), mode_with(4.0, 0.0, 0.0, 103.9)));
  EXPECT_FALSE(are_close(mode_with(1.0), mode_with(4.0, 0.0, 0.0, 104.1)));
}

TEST(ModeFlags, CloseWithinFiveStandardErrorsWhereAMultiModeFitTookTheNeighbourOut) {
  Mode refined = mode_with(1.0, 0.03);
  refined.circle_natural_frequency_hz = 100.1;
  EXPECT_TRUE(are_close(refined, mode_with(1.0, 0.04, 0.0, 100.24)));
  EXPECT_FALSE(are_close(refined, mode_with(1.0, 0.04, 0.0, 100.26)));
}

TEST(ModeFlags, SetsGetTheirFlagsOnce) {
  std::vector<Mode> modes = {mode_with(0.5), mode_with(4.0, 0.0, 0.0, 103.9),
                             mode_with(2.0, 1.0, 0.0, 150.0)};
  flag_modes(modes, 0.25, NAN, 99.9, 200.0);
  flag_modes(modes, 0.25, NAN, 99.9, 200.0);
  EXPECT_THAT(modes[0].flags, testing::ElementsAre(ModeFlag::coarse, ModeFlag::edge, ModeFlag::close_modes));
  EXPECT_THAT(modes[1].flags, testing::ElementsAre(ModeFlag::close_modes));
  EXPECT_THAT(modes[2].flags, testing::ElementsAre(ModeFlag::noisy));
}

// The lines of two poles `distance` bandwidths apart as one pole in the middle sees them, over a noise of 1.
Eigen::MatrixXcd alone(double distance, double angle, double size, Eigen::VectorXcd& g) {
  const long n = 81;
  const Eigen::Vector3d first(1.0, 0.5, -0.3);
  const Eigen::Vector3d second = std::cos(angle) * first + std::sin(angle) * Eigen::Vector3d(0.3, 0.0, 1.0);
  Eigen::MatrixXcd lines(n, 3);
  g.resize(n);
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  for (long i = 0; i < n; ++i) {
    const double x = 4.0 * static_cast<double>(i - n / 2) / static_cast<double>(n);
    const std::complex<double> i_unit(0.0, 1.0);
    g(i) = 1.0 / (x + i_unit);
    lines.row(i) = size * (first / (x - distance + i_unit) + second / (x + distance + i_unit)).transpose();
    for (long k = 0; k < 3; ++k) lines(i, k) += std::complex<double>(normal(engine), normal(engine));
  }
  return lines;
}

TEST(ModeFlags, DoubleNeedsDistanceDifferentShapesAndLittleNoise) {
  Eigen::VectorXcd g;
  Eigen::MatrixXcd lines = alone(0.3, 1.5, 100.0, g);
  EXPECT_TRUE(looks_double(lines, g));
  lines = alone(0.0, 1.5, 100.0, g);  // one frequency: rank one
  EXPECT_FALSE(looks_double(lines, g));
  lines = alone(0.3, 0.0, 100.0, g);  // parallel shapes: rank one
  EXPECT_FALSE(looks_double(lines, g));
  lines = alone(0.3, 1.5, 2.0, g);  // below the noise
  EXPECT_FALSE(looks_double(lines, g));
  EXPECT_FALSE(looks_double(lines.leftCols(1), g));  // one output cannot tell
}

TEST(ModeFlags, DoubleNeedsTheShapeOfTwoPoles) {
  Eigen::VectorXcd g;
  Eigen::MatrixXcd lines = alone(0.0, 0.0, 100.0, g);
  // A constant left over in another direction has rank two as well, but not the shape of g^2.
  lines.rowwise() += Eigen::RowVector3cd(0.0, 8.0, 20.0);
  EXPECT_FALSE(looks_double(lines, g));
}

}  // namespace
}  // namespace struna::ident
