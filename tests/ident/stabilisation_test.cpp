#include "ident/stabilisation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "ident/band_fit.hpp"
#include "ident/mode_identification.hpp"
#include "ident/noise_floor.hpp"
#include "simulated_modes.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using fem::Damping;
using simulated::add_noise;
using simulated::eight_mode_set;
using simulated::eight_modes;
using simulated::function_of;
using simulated::lines;
using simulated::SimulatedMode;

Stabilisation of_eight_modes(double level, unsigned seed) {
  const TransferFunction tf = with_noise_floor(eight_mode_set(level, seed));
  return stabilise(to_circle_form(tf, Damping::structural));
}

// A single mode's standard errors are far below these; the analysis is biased where noise is large.
void expect_the_eight_modes(const Stabilisation& found, double bandwidths, double relative) {
  const auto truth = eight_modes();
  ASSERT_EQ(found.columns.size(), truth.size());
  for (std::size_t r = 0; r < truth.size(); ++r) {
    const StableColumn& column = found.columns[r];
    const Pole& pole = truth[r].pole;
    EXPECT_NEAR(column.pole.natural_frequency_hz, pole.natural_frequency_hz, bandwidths * bandwidth_hz(pole));
    EXPECT_NEAR(column.pole.loss_factor, pole.loss_factor, relative * pole.loss_factor);
    EXPECT_GE(column.of_orders, 12);  // the lowest has 48 lines
    EXPECT_GE(4 * column.orders, 3 * column.of_orders);
    EXPECT_LT(column.frequency_spread_hz, bandwidths * bandwidth_hz(pole));
    EXPECT_LT(column.loss_factor_spread, relative * pole.loss_factor);
    const OrderCount count = orders_of(found, pole);
    EXPECT_GE(4 * count.standing, 3 * count.of);
    EXPECT_EQ(count.of, column.of_orders);
  }
}

TEST(Stabilisation, ColumnsAreTheEightModesAtOnePercentNoise) {
  for (unsigned seed = 1; seed <= 10; ++seed) expect_the_eight_modes(of_eight_modes(0.01, seed), 0.02, 0.03);
}
TEST(Stabilisation, ColumnsAreTheEightModesAtFivePercentNoise) {
  for (unsigned seed = 1; seed <= 10; ++seed) expect_the_eight_modes(of_eight_modes(0.05, seed), 0.1, 0.15);
}

TEST(Stabilisation, WindowsTileTheBand) {
  const Stabilisation found = of_eight_modes(0.01, 1);
  EXPECT_EQ(found.windows.front().territory.lo_hz, 0.25);
  EXPECT_EQ(found.windows.back().territory.hi_hz, 1200.0);
  for (std::size_t w = 0; w < found.windows.size(); ++w) {
    const StabilisationWindow& window = found.windows[w];
    if (w > 0) {
      EXPECT_EQ(window.territory.lo_hz, found.windows[w - 1].territory.hi_hz);
    }
    EXPECT_LE(window.lines.lo_hz, window.territory.lo_hz);
    EXPECT_GE(window.lines.hi_hz, window.territory.hi_hz);
  }
}

TEST(Stabilisation, PolesOfAColumnFollowOneAnother) {
  const Stabilisation found = of_eight_modes(0.05, 3);
  for (std::size_t c = 0; c < found.columns.size(); ++c) {
    int members = 0;
    std::vector<bool> seen(15, false);
    for (const OrderPole& pole : found.poles) {
      if (pole.column != static_cast<int>(c)) continue;
      ++members;
      EXPECT_FALSE(seen[static_cast<std::size_t>(pole.order)]);
      seen[static_cast<std::size_t>(pole.order)] = true;
    }
    EXPECT_EQ(members, found.columns[c].orders);
  }
}

TransferFunction noisy(const std::vector<SimulatedMode>& modes, Damping damping, double sigma,
                       unsigned seed) {
  TransferFunction tf = function_of(modes, lines(100.0, 500.0, 0.5), FrfKind::receptance, damping);
  add_noise(tf, std::vector<double>(tf.outputs.size(), sigma), seed);
  return tf;
}

// Modes of peak one or so.
std::vector<SimulatedMode> scaled(std::vector<SimulatedMode> modes, Damping damping) {
  for (SimulatedMode& mode : modes)
    for (auto& constant : mode.constant) constant *= pole_scale(mode.pole, damping);
  return modes;
}

std::vector<SimulatedMode> pair_of(double spacing_bandwidths, Damping damping) {
  return scaled({{{300.0, 0.02}, {{1.0, 0.0}, {0.4, 0.0}, {-0.6, 0.0}}},
                 {{300.0 + 6.0 * spacing_bandwidths, 0.02}, {{0.5, 0.0}, {-1.0, 0.0}, {0.8, 0.0}}}},
                damping);
}

TEST(Stabilisation, NoiseAloneHasNoColumn) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    TransferFunction tf = noisy(pair_of(3.0, Damping::structural), Damping::structural, 1.0, seed);
    for (auto& output : tf.outputs) output.value.setZero();
    add_noise(tf, {1.0, 1.0, 1.0}, seed);
    EXPECT_TRUE(stabilise(tf).columns.empty()) << "seed " << seed;
  }
}

TEST(Stabilisation, ASingleLineThatStandsOutIsNoColumn) {
  TransferFunction tf = noisy(pair_of(3.0, Damping::structural), Damping::structural, 0.01, 1);
  for (auto& output : tf.outputs) output.value(100) += 3.0;  // 150 Hz
  const Stabilisation found = stabilise(tf);
  ASSERT_EQ(found.columns.size(), 2u);
  EXPECT_GT(found.columns[0].pole.natural_frequency_hz, 290.0);
}

TEST(Stabilisation, APairHalfABandwidthApartMakesTwoColumnsForBothKindsOfDamping) {
  for (const Damping damping : {Damping::structural, Damping::viscous})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      StabilisationOptions options;
      options.damping = damping;
      const Stabilisation found = stabilise(noisy(pair_of(0.5, damping), damping, 0.002, seed), options);
      ASSERT_EQ(found.columns.size(), 2u) << fem::to_string(damping) << ", seed " << seed;
      for (std::size_t r = 0; r < 2; ++r) {
        EXPECT_NEAR(found.columns[r].pole.natural_frequency_hz, r == 0 ? 300.0 : 303.0, 0.3);
        EXPECT_NEAR(found.columns[r].pole.loss_factor, 0.02, 0.002);
      }
    }
}

// 0.3 of a bandwidth at 5 % noise: told as one, wider than either.
TEST(Stabilisation, APairBeyondTheNoiseIsOneColumn) {
  const Stabilisation found =
      stabilise(noisy(pair_of(0.3, Damping::structural), Damping::structural, 0.05, 1));
  EXPECT_EQ(found.columns.size(), 1u);
}

TEST(Stabilisation, ThirtyModesInTwoOctavesAreSeparated) {
  std::vector<SimulatedMode> modes;
  for (int r = 0; r < 30; ++r)
    modes.push_back(
        {{120.0 * std::pow(1.045, r), 0.006},
         {{std::cos(r * 1.3) + 1.5, 0.0}, {std::sin(2.1 * r) + 0.2, 0.1}, {std::cos(0.7 * r), 0.0}}});
  modes = scaled(modes, Damping::structural);
  const Stabilisation found = stabilise(noisy(modes, Damping::structural, 0.01, 1));
  ASSERT_EQ(found.columns.size(), 30u);
  for (std::size_t r = 0; r < 30; ++r)
    EXPECT_NEAR(found.columns[r].pole.natural_frequency_hz, modes[r].pole.natural_frequency_hz,
                0.1 * bandwidth_hz(modes[r].pole));
}

TEST(Stabilisation, NoOrderStandsWhereNoModeIs) {
  const Stabilisation found =
      stabilise(noisy(pair_of(3.0, Damping::structural), Damping::structural, 0.01, 1));
  EXPECT_EQ(orders_of(found, {200.0, 0.02}).standing, 0);
  EXPECT_EQ(orders_of(found, {200.0, 0.02}).of, 14);
  EXPECT_EQ(orders_of(found, {300.0, 0.06}).standing, 0);  // there, but not so damped
  EXPECT_EQ(orders_of(found, {900.0, 0.02}).of, 0);        // outside the band
}

TEST(Stabilisation, OfFewLinesHasFewOrders) {
  const TransferFunction tf = noisy(pair_of(3.0, Damping::structural), Damping::structural, 0.01, 1);
  const Stabilisation found = stabilise(restrict_band(tf, 290.0, 310.0));  // 41 lines
  ASSERT_EQ(found.windows.size(), 1u);
  EXPECT_EQ(found.windows.front().max_order, 10);
  EXPECT_NO_THROW(stabilise(restrict_band(tf, 300.0, 302.0)));
}

TEST(Stabilisation, RefusesOptionsOutOfRange) {
  const TransferFunction tf = noisy(pair_of(3.0, Damping::structural), Damping::structural, 0.01, 1);
  const auto refused = [&](auto change) {
    StabilisationOptions options;
    change(options);
    return tests::message_of([&] { stabilise(tf, options); });
  };
  using Options = StabilisationOptions;
  EXPECT_EQ(refused([](Options& o) { o.max_order = 3; }), "stabilise: max_order 4 to 60, got 3");
  EXPECT_EQ(refused([](Options& o) { o.max_order = 61; }), "stabilise: max_order 4 to 60, got 61");
  EXPECT_EQ(refused([](Options& o) { o.least_orders = 1; }),
            "stabilise: least_orders 2 to max_order 14, got 1");
  EXPECT_EQ(refused([](Options& o) { o.least_orders = 15; }),
            "stabilise: least_orders 2 to max_order 14, got 15");
  EXPECT_EQ(refused([](Options& o) { o.frequency_tolerance = 0.0; }),
            "stabilise: frequency_tolerance above 0 and up to 0.5, got 0");
  EXPECT_EQ(refused([](Options& o) { o.loss_factor_tolerance = 0.6; }),
            "stabilise: loss_factor_tolerance above 0 and up to 0.5, got 0.6");
  EXPECT_EQ(refused([](Options& o) { o.shape_tolerance = std::nan(""); }),
            "stabilise: shape_tolerance above 0 and up to 0.5, got nan");
  EXPECT_EQ(tests::message_of([&] { stabilise(restrict_band(tf, 300.0, 301.5)); }),
            "stabilise: at least 5 lines, got 4");
}

// ---- what the identification makes of it ----

TEST(Stabilisation, EveryIdentifiedModeTellsItsOrders) {
  const ModeSet set = identify_modes(eight_mode_set(0.05, 2));
  ASSERT_EQ(set.modes.size(), 8u);
  for (const Mode& mode : set.modes) {
    EXPECT_GE(4 * mode.stable_orders, 3 * mode.orders);
    EXPECT_GE(mode.orders, 10);  // the lowest has few lines
  }
  EXPECT_EQ(set.stabilisation.columns.size(), 8u);
  ModeOptions options;
  options.method = ModeMethod::circle;
  EXPECT_TRUE(identify_modes(eight_mode_set(0.05, 2), options).stabilisation.poles.empty());
}

// A candidate is tried and kept by the fit's own tests; without one and without a search there is nothing.
TEST(Stabilisation, ACandidateIsKeptWhereAModeIsAndRefusedWhereNoneIs) {
  const TransferFunction tf = noisy(pair_of(8.0, Damping::structural), Damping::structural, 0.01, 1);
  BandFitOptions options;
  options.candidates = {{300.0, 0.02}, {200.0, 0.02}};
  const BandFit fit = fit_band(tf, {}, options);
  ASSERT_EQ(fit.modes.size(), 2u);  // the other by the search of the residual
  EXPECT_NEAR(fit.modes[0].natural_frequency_hz, 300.0, 0.1);
  EXPECT_NEAR(fit.modes[1].natural_frequency_hz, 348.0, 0.1);
}

// The window's damping goes from the poles as it goes from the modes.
TEST(Stabilisation, AnExponentialWindowIsTakenOut) {
  TransferFunction tf = noisy(pair_of(8.0, Damping::viscous), Damping::viscous, 0.01, 1);
  for (auto& output : tf.outputs) {
    output.kind = FrfKind::mobility;
    output.unit = unit_of(FrfKind::mobility);
  }
  tf.exponential_decay = 6.0;
  ModeOptions options;
  options.damping = Damping::viscous;
  const ModeSet set = identify_modes(tf, options);
  ASSERT_EQ(set.modes.size(), 2u);
  ASSERT_EQ(set.stabilisation.columns.size(), 2u);
  for (std::size_t r = 0; r < 2; ++r) {
    const double added = 2.0 * 6.0 / (2.0 * std::numbers::pi * (r == 0 ? 300.0 : 348.0));
    EXPECT_NEAR(set.stabilisation.columns[r].pole.loss_factor, 0.02 - added, 0.001);
    EXPECT_NEAR(set.modes[r].loss_factor, 0.02 - added, 0.001);
  }
}

}  // namespace
}  // namespace struna::ident
