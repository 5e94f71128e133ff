#include "ident/wiring.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "synthetic_wire.hpp"

namespace struna::ident {
namespace {

using synthetic::Flaws;
using synthetic::Measured;
using synthetic::Wire;

const Wire& wire() {
  static const Wire curved = synthetic::curved_wire();
  return curved;
}

Flaws usual_flaws() {
  Flaws flaws;
  flaws.missing = flaws.doubled = 0.05;
  flaws.spurious = 0.3;
  return flaws;
}

ShapeAgreement agreement_of(const ModeSet& set, const ModelModes& model) {
  return shape_agreement(set, model, pair_modes(set, model));
}

void reverse(ModeSet& set, Eigen::Index output) {
  for (Mode& mode : set.modes) mode.modal_constant[output] *= -1.0;
}

void exchange(ModeSet& set, Eigen::Index a, Eigen::Index b) {
  for (Mode& mode : set.modes) std::swap(mode.modal_constant[a], mode.modal_constant[b]);
}

std::optional<Remedy> remedy_of(const ModeSet& set, const fem::Drive& drive) {
  const ModelModes model = elastic_modes(wire().model, drive, wire().measurement, 60).modes;
  return find_remedy(set, wire().model, drive, wire().measurement, {}, agreement_of(set, model));
}

TEST(Wiring, SoundMeasurementsAgreeOverManySeeds) {
  for (unsigned seed = 1; seed <= 15; ++seed) {
    const Measured measured = synthetic::measure(wire(), usual_flaws(), seed);
    const ShapeAgreement agreement = agreement_of(measured.set, wire().modes);
    ASSERT_GE(agreement.pairs, 10) << seed;
    EXPECT_GE(agreement.agreeing, agreement.pairs - 2) << seed;  // noise of 5 % and halves of doubled poles
    EXPECT_GT(agreement.median_mac, 0.99) << seed;
    // Noise and doubled poles shift single modes; the median of ten and more stays within some per cent.
    EXPECT_NEAR(agreement.level, 1.0, 0.05) << seed;
  }
}

TEST(Wiring, LevelIsTheCommonFactorAndBreaksNoAgreement) {
  Measured measured = synthetic::measure(wire(), usual_flaws(), 3);
  const ShapeAgreement before = agreement_of(measured.set, wire().modes);
  const Pairing pairing = pair_modes(measured.set, wire().modes);
  for (Mode& mode : measured.set.modes) {
    mode.modal_constant *= 1000.0;
    mode.modal_constant_sigma *= 1000.0;
  }
  const ShapeAgreement after = shape_agreement(measured.set, wire().modes, pairing);
  EXPECT_NEAR(after.level / before.level, 1000.0, 1e-9);  // rounding
  EXPECT_EQ(after.agreeing, before.agreeing);
}

TEST(Wiring, NamesTheReversedOutput) {
  for (Eigen::Index output = 0; output < 3; ++output) {
    Measured measured = synthetic::measure(wire(), usual_flaws(), 5);
    reverse(measured.set, output);
    const auto remedy = remedy_of(measured.set, wire().drive);
    ASSERT_TRUE(remedy) << output;
    EXPECT_EQ(remedy->change, Remedy::Change::output_reversed);
    EXPECT_EQ(remedy->outputs, std::vector<int>{static_cast<int>(output)});
    EXPECT_GT(remedy->agreement.median_mac, 0.99);
  }
}

TEST(Wiring, NamesTheExchangedOutputs) {
  Measured measured = synthetic::measure(wire(), usual_flaws(), 7);
  exchange(measured.set, 0, 1);
  auto remedy = remedy_of(measured.set, wire().drive);
  ASSERT_TRUE(remedy);
  EXPECT_EQ(remedy->change, Remedy::Change::outputs_exchanged);
  EXPECT_EQ(remedy->outputs, (std::vector<int>{1, 0, 2}));
  exchange(measured.set, 1, 2);  // now a cycle: the model's first output is the measured third
  remedy = remedy_of(measured.set, wire().drive);
  ASSERT_TRUE(remedy);
  EXPECT_EQ(remedy->outputs, (std::vector<int>{2, 0, 1}));
}

TEST(Wiring, NamesTheDriveDirection) {
  const Measured measured = synthetic::measure(wire(), usual_flaws(), 9);
  fem::SupportMotion wrong = std::get<fem::SupportMotion>(wire().drive);
  wrong.direction = Eigen::Vector3d::UnitZ();
  const auto remedy = remedy_of(measured.set, wrong);
  ASSERT_TRUE(remedy);
  EXPECT_EQ(remedy->change, Remedy::Change::driven_along);
  EXPECT_EQ(remedy->direction, Eigen::Vector3d(Eigen::Vector3d::UnitY()));
}

TEST(Wiring, FindsNoRemedyWhereNothingIsWrongOrNothingHelps) {
  const Measured sound = synthetic::measure(wire(), usual_flaws(), 11);
  EXPECT_FALSE(remedy_of(sound.set, wire().drive));
  // The modes of another wire.
  const Wire other = synthetic::wire(
      fem::spline_through({{0, 0, 0}, {0.2, -0.1, 0.1}, {0.3, 0.1, 0.15}, {0.5, 0.1, -0.1}}, 0.5), 3);
  const Measured foreign = synthetic::measure(other, usual_flaws(), 11);
  EXPECT_FALSE(remedy_of(foreign.set, wire().drive));
}

TEST(Wiring, ModesWithoutConstantsSayNothing) {
  Measured measured = synthetic::measure(wire(), usual_flaws(), 1);
  for (Mode& mode : measured.set.modes) mode.modal_constant.resize(0);
  const ShapeAgreement agreement = agreement_of(measured.set, wire().modes);
  EXPECT_EQ(agreement.modes, 0);
  EXPECT_EQ(agreement.pairs, 0);
  EXPECT_TRUE(std::isnan(agreement.median_mac));
  EXPECT_EQ(shape_agreement({}, wire().modes, {}).modes, 0);
}

}  // namespace
}  // namespace struna::ident
