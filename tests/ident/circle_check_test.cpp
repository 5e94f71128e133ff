#include "ident/circle_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "ident/circle_fit.hpp"
#include "ident/mode_groups.hpp"
#include "simulated_modes.hpp"

namespace struna::ident::simulated {
namespace {

constexpr Pole first{100.0, 0.02};
constexpr double bandwidth = 2.0;

/// Modes at 100 Hz and `apart` bandwidths above, of different shape.
TransferFunction pair_of(double apart, double noise, unsigned seed, double lines_per_bandwidth = 20.0) {
  std::vector<SimulatedMode> modes = {{first, {1.0, 0.6}}};
  if (apart > 0.0) modes.push_back({{100.0 + apart * bandwidth, 0.02}, {0.9, -0.7}});
  for (auto& mode : modes)
    for (auto& constant : mode.constant) constant *= pole_scale(mode.pole, fem::Damping::structural);
  TransferFunction tf =
      function_of(modes, lines(70.0, 150.0, bandwidth / lines_per_bandwidth), FrfKind::receptance);
  add_noise(tf, {noise, noise}, seed);
  return tf;
}

Mode circle_at(const TransferFunction& tf, double f_hz) {
  return fit_circle(tf, f_hz, f_hz - bandwidth, f_hz + bandwidth);
}

Mode judged(const TransferFunction& tf, std::vector<Mode> circles) {
  judge_circles(tf, fem::Damping::structural, true, circles);
  return circles.front();
}

TEST(CircleCheck, StandardErrorsHoldWhatANeighbourBends) {
  for (const double apart : {3.0, 5.0}) {
    const TransferFunction tf = pair_of(apart, 3e-4, 1, 32.0);
    const Mode alone = circle_at(tf, 100.0);
    const Mode mode = judged(tf, {alone, circle_at(tf, 100.0 + apart * bandwidth)});
    const double error = std::abs(mode.loss_factor - 0.02);
    EXPECT_GT(error, 3.0 * alone.loss_factor_sigma) << apart;
    // The error itself but for the noise of the fit together, some 2e-4.
    EXPECT_NEAR(mode.loss_factor_sigma / error, 1.0, 0.05) << apart;
    EXPECT_EQ(mode.has(ModeFlag::close_modes), error > 0.01 * 0.02) << apart;
    EXPECT_EQ(mode.loss_factor, alone.loss_factor);
    EXPECT_EQ(mode.natural_frequency_hz, alone.natural_frequency_hz);
  }
}

TEST(CircleCheck, LoneModesKeepTheirStandardErrorsAndCarryNoFlag) {
  constexpr unsigned seeds = 200;
  double before = 0.0, after = 0.0, squared = 0.0;
  unsigned flagged = 0;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const TransferFunction tf = pair_of(0.0, 0.01, seed);
    const Mode alone = circle_at(tf, 100.0), mode = judged(tf, {alone});
    before += alone.loss_factor_sigma;
    after += mode.loss_factor_sigma;
    squared += std::pow((mode.loss_factor - 0.02) / mode.loss_factor_sigma, 2.0);
    flagged += mode.flags.empty() ? 0 : 1;
  }
  EXPECT_LT(after / before, 1.25);           // the larger of two estimates
  EXPECT_NEAR(squared / seeds, 0.75, 0.25);  // which is why it is below one
  EXPECT_LE(flagged, 19u);                   // ten hints of one chance in 20, three times their scatter
}

TEST(CircleCheck, FindsASecondModeThatTheCirclesWindowHides) {
  unsigned found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const TransferFunction tf = pair_of(0.1, 0.02, seed);
    const Mode alone = circle_at(tf, 100.1), mode = judged(tf, {alone});
    EXPECT_TRUE(alone.flags.empty()) << seed;
    EXPECT_TRUE(std::isnan(alone.resolves_from));
    EXPECT_LT(mode.resolves_from, 0.2);
    found += mode.has(ModeFlag::double_mode) || mode.has(ModeFlag::may_be_two) ? 1 : 0;
  }
  EXPECT_GE(found, 18u);
}

TEST(CircleCheck, CircleWithoutSupportBesideItsNeighbourIsNotItsOwn) {
  const TransferFunction tf = pair_of(0.0, 0.01, 1);
  Mode shoulder = circle_at(tf, 100.0);
  shoulder.natural_frequency_hz += 0.02 * bandwidth;
  std::vector<Mode> circles = {circle_at(tf, 100.0), shoulder};
  judge_circles(tf, fem::Damping::structural, true, circles);
  EXPECT_TRUE(circles[0].has(ModeFlag::close_modes) != circles[1].has(ModeFlag::close_modes));
}

TEST(CircleCheck, TooFewLinesForTheFitTogetherTellNothing) {
  std::vector<SimulatedMode> modes = {{first, {1.0}}};
  modes[0].constant[0] *= pole_scale(first, fem::Damping::structural);
  TransferFunction tf = function_of(modes, lines(98.0, 102.0, 1.0), FrfKind::receptance);
  add_noise(tf, {1e-4}, 1);
  ASSERT_EQ(tf.lines(), 5);
  EXPECT_FALSE(judged(tf, {circle_at(tf, 100.0)}).has(ModeFlag::close_modes));
}

TEST(CircleCheck, NoCirclesNoJudgement) {
  std::vector<Mode> none;
  judge_circles(pair_of(0.0, 0.01, 1), fem::Damping::structural, true, none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace struna::ident::simulated
