#include "ident/pairing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fem/error.hpp"
#include "synthetic_wire.hpp"

namespace struna::ident {
namespace {

using synthetic::Flaws;
using synthetic::Measured;
using synthetic::Score;
using synthetic::Wire;

Flaws none() {
  Flaws flaws;
  flaws.missing = flaws.doubled = flaws.spurious = flaws.model_error = 0.0;
  flaws.constant_noise = flaws.frequency_noise = 1e-6;
  return flaws;
}

void strip_constants(ModeSet& set) {
  set.outputs.clear();
  set.form = FrfKind::unknown;
  for (Mode& mode : set.modes) {
    mode.modal_constant.resize(0);
    mode.modal_constant_sigma.resize(0);
  }
}

/// Sum of scores over seeds.
Score over_seeds(const Wire& wire, const Flaws& flaws, int seeds, bool with_constants) {
  Score total;
  for (int seed = 1; seed <= seeds; ++seed) {
    Measured measured = synthetic::measure(wire, flaws, static_cast<unsigned>(seed));
    if (!with_constants) strip_constants(measured.set);
    const Score one = synthetic::score(pair_modes(measured.set, wire.modes), measured);
    EXPECT_EQ(one.wrong, 0) << "seed " << seed;
    total.right += one.right;
    total.left_out += one.left_out;
    total.spurious_paired += one.spurious_paired;
  }
  return total;
}

TEST(Pairing, PairsEveryModeOfAFlawlessMeasurement) {
  const Wire wire = synthetic::curved_wire();
  const Measured measured = synthetic::measure(wire, none(), 1);
  const Pairing pairing = pair_modes(measured.set, wire.modes);
  ASSERT_EQ(pairing.pairs.size(), measured.set.modes.size());
  const Score s = synthetic::score(pairing, measured);
  EXPECT_EQ(s.wrong, 0);
  EXPECT_TRUE(pairing.left_out.empty());
  // The mode at 316.9 Hz answers this drive a thousandth as strongly as its neighbour 0.3 bandwidths below:
  // whether that one's pole stands for both is open.
  EXPECT_THAT(pairing.missing, ::testing::Each(10));
  EXPECT_FALSE(pairing.sign_reversed);
  for (const Pair& pair : pairing.pairs) {
    const Mode& mode = measured.set.modes[static_cast<std::size_t>(pair.measured)];
    // A single pole is exact up to the frequency noise of 1e-6 bandwidths; one for two lies where the test's
    // own sum puts it, with weights taken on other eigenvalue scales (second order in the spacing).
    const double tolerance = pair.model.size() == 1 ? 1e-6 : 1e-5;
    EXPECT_NEAR(pair.modulus / synthetic::true_modulus().at(mode.natural_frequency_hz), 1.0, tolerance);
    EXPECT_GT(pair.mac, 0.999);
    EXPECT_GE(pair.modulus_sigma,
              2.0 * mode.natural_frequency_sigma / mode.natural_frequency_hz * pair.modulus * 0.999);
  }
  EXPECT_NEAR(pairing.modulus_at_1_hz * std::pow(100.0, pairing.modulus_slope) / 1e11, 1.0,
              1e-3);  // Sbplx' stop
  EXPECT_NEAR(pairing.modulus_slope, 0.02, 5e-3);
}

TEST(Pairing, NoPairIsWrongOnACurvedWireWithThreeOutputs) {
  const Score total = over_seeds(synthetic::curved_wire(), {}, 15, true);
  EXPECT_EQ(total.spurious_paired, 0);
  EXPECT_LE(total.left_out, 0.05 * total.right);  // true modes lost: below one in twenty
}

TEST(Pairing, NoPairIsWrongWithOneOutput) {
  const Score total = over_seeds(synthetic::curved_wire(1), {}, 10, true);
  EXPECT_LE(total.spurious_paired,
            1);  // one output cannot always tell a spurious pole that falls on a missing mode
  EXPECT_LE(total.left_out, 0.05 * total.right);
}

TEST(Pairing, NoPairIsWrongInAHandMadeListWithoutConstants) {
  const Score total = over_seeds(synthetic::curved_wire(), {}, 8, false);
  EXPECT_LE(total.left_out, 0.2 * total.right);  // without constants more stays ambiguous
  const Score straight = over_seeds(synthetic::straight_wire(), {}, 8, false);
  EXPECT_LE(straight.left_out, 0.2 * straight.right);
}

TEST(Pairing, NoPairIsWrongOnAStraightWire) {
  const Score total = over_seeds(synthetic::straight_wire(), {}, 10, true);
  EXPECT_LE(total.left_out, 0.05 * total.right);
}

TEST(Pairing, AListThatStartsInTheMiddleIsNotShiftedByOne) {
  const Wire wire = synthetic::straight_wire();
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Flaws flaws = none();
    flaws.frequency_noise = 0.005;
    Measured measured = synthetic::measure(wire, flaws, seed);
    for (int k = 0; k < 4; ++k) {
      measured.set.modes.erase(measured.set.modes.begin());
      measured.truth.erase(measured.truth.begin());
    }
    const Score s = synthetic::score(pair_modes(measured.set, wire.modes), measured);
    EXPECT_EQ(s.wrong, 0) << "seed " << seed;
    EXPECT_EQ(s.left_out, 0) << "seed " << seed;
  }
}

TEST(Pairing, TellsWhenAllSignsAreReversed) {
  const Wire wire = synthetic::curved_wire();
  Measured measured = synthetic::measure(wire, {}, 3);
  for (Mode& mode : measured.set.modes) mode.modal_constant *= -1.0;
  const Pairing pairing = pair_modes(measured.set, wire.modes);
  EXPECT_TRUE(pairing.sign_reversed);
  EXPECT_EQ(synthetic::score(pairing, measured).wrong, 0);
}

TEST(Pairing, OnePoleForANearlyDoublePairIsAGroup) {
  const Wire wire = synthetic::curved_wire();
  const Measured measured = synthetic::measure(wire, none(), 1);
  const Pairing pairing = pair_modes(measured.set, wire.modes);
  int groups = 0;
  for (const Pair& pair : pairing.pairs) {
    if (pair.model.size() < 2) continue;
    ++groups;
    EXPECT_EQ(pair.model, measured.truth[static_cast<std::size_t>(pair.measured)]);
    const double step =
        0.5 * std::log(wire.modes.eigenvalue[pair.model[1]] / wire.modes.eigenvalue[pair.model[0]]);
    EXPECT_GT(pair.spread, 0.0);
    EXPECT_LE(pair.spread, step * 1.01);  // equal shares at most; 1 % from the logarithm
    EXPECT_GE(pair.modulus_sigma, 0.5 * pair.spread * pair.modulus);
  }
  EXPECT_GE(groups, 3);  // this wire's pairs near 552, 693 and 850 Hz
}

TEST(Pairing, NamesTheModesThatWereNotMeasured) {
  const Wire wire = synthetic::curved_wire();
  Measured measured = synthetic::measure(wire, none(), 1);
  const std::vector<int> lost = measured.truth[5];
  measured.set.modes.erase(measured.set.modes.begin() + 5);
  const Pairing pairing = pair_modes(measured.set, wire.modes);
  for (int mode : lost) EXPECT_THAT(pairing.missing, ::testing::Contains(mode));
  EXPECT_THAT(pairing.missing, ::testing::Each(::testing::AnyOf(lost.front(), lost.back(), 10)));
}

TEST(Pairing, LeavesOutASpuriousModeWithItsReason) {
  const Wire wire = synthetic::curved_wire();
  Measured measured = synthetic::measure(wire, none(), 1);
  Mode stray = measured.set.modes[5];
  stray.natural_frequency_hz *= 1.25;
  measured.set.modes.push_back(stray);
  const Pairing pairing = pair_modes(measured.set, wire.modes);
  ASSERT_EQ(pairing.left_out.size(), 1u);
  EXPECT_EQ(pairing.left_out[0].measured, static_cast<int>(measured.set.modes.size()) - 1);
  EXPECT_THAT(pairing.left_out[0].reason, ::testing::HasSubstr("unpaired: "));
}

/// Every `step`th mode from `first` on.
Measured some_of(const Measured& all, std::size_t first, std::size_t step) {
  Measured some = all;
  some.set.modes.clear();
  some.truth.clear();
  for (std::size_t i = first; i < all.set.modes.size(); i += step) {
    some.set.modes.push_back(all.set.modes[i]);
    some.truth.push_back(all.truth[i]);
  }
  return some;
}

TEST(Pairing, AQuarterOfTheModesIsPairedRightlyAndNotOpen) {
  const Wire wire = synthetic::curved_wire();
  Flaws flaws;
  flaws.missing = flaws.doubled = flaws.spurious = 0.0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    for (std::size_t first = 0; first < 4; ++first) {
      const Measured few = some_of(synthetic::measure(wire, flaws, seed), first, 4);
      const Pairing pairing = pair_modes(few.set, wire.modes);
      EXPECT_GE(pairing.pairs.size() + 1, few.set.modes.size()) << "seed " << seed << " from " << first;
      EXPECT_EQ(synthetic::score(pairing, few).wrong, 0) << "seed " << seed << " from " << first;
      EXPECT_LT(pairing.rival.odds, 0.05) << "seed " << seed << " from " << first;
    }
  }
}

TEST(Pairing, ModesOfNoneOfTheModelsAreOpenOrLeftOut) {
  const Wire wire = synthetic::curved_wire();
  int settled = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Measured measured = synthetic::measure(wire, none(), 1);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(std::log(15.0), std::log(1000.0));
    measured.set.modes.resize(3);
    for (Mode& mode : measured.set.modes) {
      mode.natural_frequency_hz = std::exp(uniform(random));
      const double length = mode.modal_constant.norm();
      for (auto& c : mode.modal_constant) c = normal(random);
      mode.modal_constant *= length / mode.modal_constant.norm();
    }
    const Pairing pairing = pair_modes(measured.set, wire.modes);
    settled += !pairing.pairs.empty() && pairing.rival.odds < 0.05;
  }
  EXPECT_LE(settled, 2);  // odds of 1 to 20 are wrong as often
}

TEST(Pairing, AModeThatTakesAMissingOnesPlaceIsToldByItsConstants) {
  const Wire wire = synthetic::curved_wire();
  Measured measured = synthetic::measure(wire, none(), 1);
  Mode& stray = measured.set.modes[5];
  stray.natural_frequency_hz *= 1.002;
  const double length = stray.modal_constant.norm();
  const Eigen::Vector3cd true_constant = stray.modal_constant;
  stray.modal_constant += 0.5 * length * Eigen::Vector3cd(0.6, -0.8, 0.0);
  const Pairing pairing = pair_modes(measured.set, wire.modes);
  ASSERT_EQ(pairing.left_out.size(), 1u);
  EXPECT_EQ(pairing.left_out[0].measured, 5);
  EXPECT_THAT(pairing.left_out[0].reason, ::testing::HasSubstr("its modal constants are 50 % off"));
  // Noise that all have alike is none of one mode's.
  stray.modal_constant = true_constant * 1.1;
  EXPECT_TRUE(pair_modes(measured.set, wire.modes).left_out.empty());
}

TEST(Pairing, UnitsOfTheConstantsChangeNoPair) {
  const Wire wire = synthetic::curved_wire();
  for (const double factor : {1e-3, 9.80665, 1e3}) {
    Measured measured = synthetic::measure(wire, {}, 2);
    const std::size_t pairs = pair_modes(measured.set, wire.modes).pairs.size();
    for (Mode& mode : measured.set.modes) {
      mode.modal_constant *= factor;
      mode.modal_constant_sigma *= factor;
    }
    const Pairing pairing = pair_modes(measured.set, wire.modes);
    EXPECT_EQ(pairing.pairs.size(), pairs) << factor;
    EXPECT_EQ(synthetic::score(pairing, measured).wrong, 0) << factor;
  }
}

TEST(Pairing, ViscousConstantsPairLikeStructuralOnes) {
  const Wire wire = synthetic::curved_wire();
  Measured measured = synthetic::measure(wire, none(), 1);
  measured.set.damping = fem::Damping::viscous;
  for (Mode& mode : measured.set.modes) {  // residue at the pole, of the apparent mass: C/(2 i omega_r)
    mode.modal_constant /= std::complex<double>(0.0, 4.0 * std::numbers::pi * mode.natural_frequency_hz);
  }
  const Pairing pairing = pair_modes(measured.set, wire.modes);
  EXPECT_EQ(pairing.pairs.size(), measured.set.modes.size());
  EXPECT_FALSE(pairing.sign_reversed);
}

TEST(Pairing, RefusesWhatCannotBePaired) {
  const Wire wire = synthetic::curved_wire();
  const Measured measured = synthetic::measure(wire, none(), 1);
  EXPECT_TRUE(pair_modes(ModeSet{}, wire.modes).pairs.empty());
  EXPECT_THROW(pair_modes(measured.set, ModelModes{}), Error);
  ModelModes unsorted = wire.modes;
  std::swap(unsorted.eigenvalue[0], unsorted.eigenvalue[1]);
  EXPECT_THROW(pair_modes(measured.set, unsorted), Error);
  ModelModes fewer_outputs = wire.modes;
  fewer_outputs.constant.conservativeResize(Eigen::NoChange, 2);
  EXPECT_THROW(pair_modes(measured.set, fewer_outputs), Error);
  ModeSet nameless = measured.set;
  nameless.modes[0].natural_frequency_hz = 0.0;
  EXPECT_THROW(pair_modes(nameless, wire.modes), Error);

  const std::vector<PairingOptions> bad = {{.modulus_lo = 0.0}, {.modulus_lo = 1e13},
                                           {.slope_lo = 0.4},   {.slope_lo = -3.0},
                                           {.slope_hi = 2.0},   {.band_lo_hz = 10.0, .band_hi_hz = 5.0}};
  for (const PairingOptions& options : bad)
    EXPECT_THROW(pair_modes(measured.set, wire.modes, options), Error);
}

}  // namespace
}  // namespace struna::ident
