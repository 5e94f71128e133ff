#include "ident/mode_identification.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "tests/ident/simulated_modes.hpp"

namespace struna::ident {
namespace {

using simulated::function_of;
using simulated::lines;
using simulated::SimulatedMode;

ModeOptions in_band(double lo_hz, double hi_hz, ModeMethod method = ModeMethod::automatic) {
  ModeOptions options;
  options.band_lo_hz = lo_hz;
  options.band_hi_hz = hi_hz;
  options.method = method;
  return options;
}

/// A lone mode at 100 Hz of peak 1 in one output, with noise of `sigma` per part.
TransferFunction lone_mode(double loss_factor, double spacing_hz, double sigma) {
  const Pole pole{100.0, loss_factor};
  auto tf = function_of({{pole, {pole_scale(pole, fem::Damping::structural)}}},
                        lines(60.0, 140.0, spacing_hz), FrfKind::apparent_mass);
  simulated::add_noise(tf, {sigma}, 11);
  return tf;
}

// The eight-mode set without frequency guesses: every mode found, the close pair apart, none added.
TEST(ModeIdentification, FindsTheEightModesAndNoOther) {
  const auto modes = simulated::eight_modes();
  for (const double level : {0.01, 0.05}) {
    double score = 0.0;
    const unsigned seeds = 5;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      const ModeSet set = identify_modes(simulated::eight_mode_set(level, seed));
      ASSERT_EQ(set.modes.size(), modes.size()) << "level " << level << " seed " << seed;
      for (std::size_t r = 0; r < modes.size(); ++r) {
        const Mode& mode = set.modes[r];
        const Pole& truth = modes[r].pole;
        // Five standard errors: once in a million.
        EXPECT_LT(std::abs(mode.natural_frequency_hz - truth.natural_frequency_hz),
                  5.0 * mode.natural_frequency_sigma)
            << truth.natural_frequency_hz << " Hz, seed " << seed;
        EXPECT_LT(std::abs(mode.loss_factor - truth.loss_factor), 5.0 * mode.loss_factor_sigma)
            << truth.natural_frequency_hz << " Hz, seed " << seed;
        score += std::pow((mode.loss_factor - truth.loss_factor) / mode.loss_factor_sigma, 2.0);
      }
    }
    // 40 squared scores: mean 1, four standard deviations 4 sqrt(2/40).
    EXPECT_NEAR(score / (8.0 * seeds), 1.0, 0.9) << "level " << level;
  }
}

TEST(ModeIdentification, DoesNotDependOnWhereTheBandStarts) {
  const auto tf = simulated::eight_mode_set(0.01, 2);
  const ModeSet whole = identify_modes(tf);
  const ModeSet part = identify_modes(tf, in_band(80.0, 480.0));
  ASSERT_EQ(whole.modes.size(), 8u);
  ASSERT_EQ(part.modes.size(), 3u);
  for (std::size_t r = 0; r < 3; ++r) {
    // The same lines around each mode; the residual terms differ a little.
    EXPECT_NEAR(part.modes[r].natural_frequency_hz, whole.modes[r + 2].natural_frequency_hz,
                2.0 * whole.modes[r + 2].natural_frequency_sigma);
    EXPECT_NEAR(part.modes[r].loss_factor, whole.modes[r + 2].loss_factor,
                2.0 * whole.modes[r + 2].loss_factor_sigma);
  }
}

TEST(ModeIdentification, NoiseAloneHasNoModes) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Pole pole{1e4, 0.01};  // far outside
    auto tf = function_of({{pole, {1.0, 1.0, 1.0}}}, lines(10.0, 500.0, 0.25), FrfKind::receptance);
    simulated::add_noise(tf, {1.0, 1.0, 1.0}, seed);
    EXPECT_TRUE(identify_modes(tf).modes.empty()) << "seed " << seed;
  }
}

TEST(ModeIdentification, TakesTheUsersFrequencies) {
  const auto tf = simulated::eight_mode_set(0.01, 4);
  ModeOptions options;
  options.frequencies_hz = {61.0, 340.0};
  const ModeSet only = identify_modes(tf, options);
  ASSERT_EQ(only.modes.size(), 2u);
  EXPECT_NEAR(only.modes[0].natural_frequency_hz, 61.0, 0.2);
  EXPECT_NEAR(only.modes[1].natural_frequency_hz, 340.0, 0.2);
}

TEST(ModeIdentification, EveryMethodGivesTheSameModes) {
  const auto tf = lone_mode(0.02, 0.1, 1e-3);
  for (const auto method :
       {ModeMethod::automatic, ModeMethod::circle, ModeMethod::half_power, ModeMethod::multi}) {
    const ModeSet set = identify_modes(tf, in_band(60.0, 140.0, method));
    ASSERT_EQ(set.modes.size(), 1u) << to_string(method);
    EXPECT_NEAR(set.modes[0].natural_frequency_hz, 100.0, 0.02)
        << to_string(method);  // a hundredth of a bandwidth
    EXPECT_NEAR(set.modes[0].loss_factor, 0.02, 4e-4) << to_string(method);
    EXPECT_EQ(set.form, FrfKind::apparent_mass);
  }
}

TEST(ModeIdentification, TakesTheExponentialWindowsDampingOut) {
  const double decay = 3.0;  // 1/s: zeta + decay/omega
  const double omega = 2.0 * std::numbers::pi * 100.0;
  auto tf = lone_mode(0.02 + 2.0 * decay / omega, 0.1, 1e-4);
  tf.exponential_decay = decay;
  const ModeSet set = identify_modes(tf);
  ASSERT_EQ(set.modes.size(), 1u);
  EXPECT_NEAR(set.modes[0].loss_factor, 0.02, 5.0 * set.modes[0].loss_factor_sigma);
  EXPECT_NEAR(set.modes[0].damping_ratio, 0.01, 5.0 * set.modes[0].loss_factor_sigma);
}

TEST(ModeIdentification, FlagsStandOnBothSidesOfTheirBorders) {
  const auto flagged = [](const TransferFunction& tf, ModeFlag flag, ModeOptions options = {}) {
    options.frequencies_hz = {100.0};
    const ModeSet set = identify_modes(tf, options);
    EXPECT_FALSE(set.modes.empty());
    return !set.modes.empty() && set.modes[0].has(flag);
  };
  // Bandwidth 2 Hz: 2.5 and 10 line spacings.
  EXPECT_TRUE(flagged(lone_mode(0.02, 0.8, 1e-3), ModeFlag::coarse));
  EXPECT_FALSE(flagged(lone_mode(0.02, 0.2, 1e-3), ModeFlag::coarse));
  // The half-power band reaches from 99 to 101 Hz.
  EXPECT_TRUE(flagged(lone_mode(0.02, 0.1, 1e-4), ModeFlag::edge, in_band(90.0, 100.8)));
  EXPECT_FALSE(flagged(lone_mode(0.02, 0.1, 1e-4), ModeFlag::edge, in_band(90.0, 110.0)));
  EXPECT_TRUE(flagged(lone_mode(0.02, 0.5, 0.15), ModeFlag::noisy));
  EXPECT_FALSE(flagged(lone_mode(0.02, 0.5, 0.01), ModeFlag::noisy));
}

TEST(ModeIdentification, CloseModesAreFlaggedWithinABandwidth) {
  for (const auto& [spacing, close] : {std::pair{0.7, true}, std::pair{2.0, false}}) {
    const Pole a{100.0, 0.02}, b{100.0 + spacing * 2.0, 0.02};
    const double scale = pole_scale(a, fem::Damping::structural);
    auto tf = function_of({{a, {scale, 0.5 * scale}}, {b, {-0.4 * scale, scale}}}, lines(60.0, 140.0, 0.1),
                          FrfKind::apparent_mass);
    simulated::add_noise(tf, {1e-4, 1e-4}, 5);
    const ModeSet set = identify_modes(tf);
    ASSERT_EQ(set.modes.size(), 2u) << spacing;
    for (const Mode& mode : set.modes) EXPECT_EQ(mode.has(ModeFlag::close_modes), close) << spacing;
  }
}

TEST(ModeIdentification, RefusesWhatItCannotUse) {
  const auto tf = lone_mode(0.02, 0.1, 1e-3);
  EXPECT_THROW(identify_modes(tf, in_band(200.0, 300.0)), Error);  // no lines
  EXPECT_THROW(identify_modes(tf, in_band(140.0, 60.0)), Error);
  ModeOptions outside;
  outside.frequencies_hz = {500.0};
  EXPECT_THROW(identify_modes(tf, outside), Error);
  EXPECT_THROW(mode_method("circles"), Error);
}

}  // namespace
}  // namespace struna::ident
