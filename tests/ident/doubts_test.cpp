#include "ident/doubts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fem/error.hpp"
#include "synthetic_wire.hpp"

namespace struna::ident {
namespace {

using synthetic::Flaws;
using synthetic::Measured;
using synthetic::Wire;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const Wire& wire() {
  static const Wire curved = synthetic::curved_wire();
  return curved;
}

ModeSet measured_modes(unsigned seed, double model_error = 0.001) {
  Flaws flaws;
  flaws.missing = flaws.doubled = 0.05;
  flaws.spurious = 0.0;
  flaws.model_error = model_error;
  ModeSet set = synthetic::measure(wire(), flaws, seed).set;
  set.outputs = {"force_y", "force_x", "force_z"};
  return set;
}

struct Study {
  IdentifiedParameters identified;
  std::vector<Doubt> doubts;
};

Study study(const ModeSet& set, const Wire& model = wire(), const FitOptions& options = {}) {
  Study result;
  result.identified = identify_parameters(set, model.model, model.drive, model.measurement, options);
  result.doubts =
      identification_doubts(set, model.model, model.drive, model.measurement, options, result.identified);
  return result;
}

const Doubt* find(const std::vector<Doubt>& doubts, DoubtKind kind) {
  const auto at = std::find_if(doubts.begin(), doubts.end(), [&](const Doubt& d) { return d.kind == kind; });
  return at == doubts.end() ? nullptr : &*at;
}

std::string texts(const std::vector<Doubt>& doubts) {
  std::string all;
  for (const Doubt& doubt : doubts) all += to_string(doubt.kind) + ": " + sentence(doubt) + "\n";
  return all;
}

TEST(Doubts, SoundMeasurementsRaiseNone) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const Study s = study(measured_modes(seed));
    EXPECT_THAT(s.doubts, IsEmpty()) << "seed " << seed << "\n" << texts(s.doubts);
  }
}

TEST(Doubts, BandAndGivenFloorsRaiseNone) {
  FitOptions options;
  options.band_lo_hz = 60.0;
  options.band_hi_hz = 700.0;
  const Study s = study(measured_modes(2), wire(), options);
  EXPECT_THAT(s.doubts, IsEmpty()) << texts(s.doubts);
}

TEST(Doubts, ReversedOutputIsNamedAndNoModeTrusted) {
  ModeSet set = measured_modes(1);
  for (Mode& mode : set.modes) mode.modal_constant[0] *= -1.0;
  Study s = study(set);
  const Doubt* doubt = find(s.doubts, DoubtKind::shapes_disagree);
  ASSERT_NE(doubt, nullptr) << texts(s.doubts);
  EXPECT_THAT(sentence(*doubt), HasSubstr("with force_y reversed"));
  EXPECT_THAT(sentence(*doubt), HasSubstr("[channel.force_y]"));
  EXPECT_TRUE(question_the_model(s.doubts));
  ASSERT_TRUE(shapes_disagree_grossly(s.doubts));
  const auto laws = s.identified.modulus.laws.size();
  withdraw_trust(s.identified);
  EXPECT_EQ(s.identified.modulus.value.size(), 0);
  EXPECT_EQ(s.identified.loss_factor.value.size(), 0);
  EXPECT_EQ(s.identified.modulus.laws.size(), laws);
  for (const Mode& mode : set.modes) {  // each is told once
    EXPECT_EQ(std::count_if(s.identified.rejected.begin(), s.identified.rejected.end(),
                            [&](const LeftOut& l) { return l.frequency_hz == mode.natural_frequency_hz; }),
              1);
  }
}

TEST(Doubts, ExchangedOutputsAreNamed) {
  ModeSet set = measured_modes(2);
  for (Mode& mode : set.modes) std::swap(mode.modal_constant[0], mode.modal_constant[2]);
  const Study s = study(set);
  ASSERT_FALSE(s.doubts.empty());
  EXPECT_THAT(sentence(s.doubts.front()),
              HasSubstr("force_z taken for force_y and force_y taken for force_z"));
  EXPECT_EQ(find(s.doubts, DoubtKind::sign_reversed), nullptr) << "the remedy explains the signs";
}

TEST(Doubts, WrongDriveIsNamed) {
  Wire wrong = wire();
  std::get<fem::SupportMotion>(wrong.drive).direction = Eigen::Vector3d::UnitZ();
  const Study s = study(measured_modes(3), wrong);
  ASSERT_FALSE(s.doubts.empty());
  EXPECT_THAT(sentence(s.doubts.front()), HasSubstr("driven along y"));
}

TEST(Doubts, AnotherStructureIsDoubtedWithoutRemedy) {
  const Wire other = synthetic::wire(
      fem::spline_through({{0, 0, 0}, {0.2, -0.1, 0.1}, {0.3, 0.1, 0.15}, {0.5, 0.1, -0.1}}, 0.5), 3);
  const Study s = study(measured_modes(4), other);
  ASSERT_FALSE(s.doubts.empty());
  EXPECT_FALSE(s.doubts.front().remedy);
  EXPECT_TRUE(question_the_model(s.doubts));
}

TEST(Doubts, SignOfEverythingIsOneDoubt) {
  ModeSet set = measured_modes(5);
  for (Mode& mode : set.modes) mode.modal_constant *= -1.0;
  const Study s = study(set);
  ASSERT_EQ(s.doubts.size(), 1u) << texts(s.doubts);
  EXPECT_EQ(s.doubts[0].kind, DoubtKind::sign_reversed);
}

TEST(Doubts, LevelOffsetNamesItsFactor) {
  for (const auto& [factor, told] : {std::pair<double, const char*>{1000.0, "mm taken for m"},
                                     {1.0 / 9.80665, "g taken for m/s^2"},
                                     {1.5, "times larger"}}) {
    ModeSet set = measured_modes(6);
    for (Mode& mode : set.modes) mode.modal_constant *= factor;
    const Study s = study(set);
    const Doubt* doubt = find(s.doubts, DoubtKind::level_offset);
    ASSERT_NE(doubt, nullptr) << factor << texts(s.doubts);
    EXPECT_NEAR(doubt->value / factor, 1.0, 0.03);  // the median of the constants' noise
    EXPECT_THAT(sentence(*doubt), HasSubstr(told));
    EXPECT_TRUE(question_the_model(s.doubts));
  }
  ModeSet set = measured_modes(6);
  for (Mode& mode : set.modes) mode.modal_constant *= 1.1;  // calibrations are that bad
  EXPECT_EQ(find(study(set).doubts, DoubtKind::level_offset), nullptr);
}

TEST(Doubts, ScatterOfTheModuliIsALawThatMisfits) {
  const Study s = study(measured_modes(7, 0.006));
  const Doubt* doubt = find(s.doubts, DoubtKind::law_misfit);
  ASSERT_NE(doubt, nullptr) << texts(s.doubts);
  EXPECT_EQ(doubt->names.front(), "modulus");
  EXPECT_NEAR(doubt->other, 0.012, 0.006);  // twice that of the frequencies; a dozen modes
}

TEST(Doubts, LossFactorLawIsNoMatterToViscousModes) {
  ModeSet set = measured_modes(1);
  for (std::size_t i = 0; i < set.modes.size(); ++i) set.modes[i].loss_factor *= i % 2 == 0 ? 1.3 : 0.8;
  const Study structural = study(set);
  const Doubt* doubt = find(structural.doubts, DoubtKind::law_misfit);
  ASSERT_NE(doubt, nullptr) << texts(structural.doubts);
  EXPECT_EQ(doubt->names.front(), "loss factor");
  EXPECT_THAT(sentence(*doubt), HasSubstr("--loss-factor-law"));
  EXPECT_FALSE(question_the_model(structural.doubts));
  set.damping = fem::Damping::viscous;
  for (Mode& mode : set.modes) {  // the same modes as viscous residues
    mode.modal_constant /= std::complex<double>(0.0, 4.0 * std::numbers::pi * mode.natural_frequency_hz);
    mode.modal_constant_sigma /= 4.0 * std::numbers::pi * mode.natural_frequency_hz;
  }
  EXPECT_THAT(study(set).doubts, IsEmpty()) << texts(study(set).doubts);
}

TEST(Doubts, UnseenStrongModesAreTold) {
  ModeSet set = measured_modes(8);
  std::vector<Mode> every_other;
  for (std::size_t i = 0; i < set.modes.size(); ++i) {
    if (i % 3 == 0 || i + 1 == set.modes.size()) every_other.push_back(set.modes[i]);
  }
  set.modes = every_other;
  const Study s = study(set);
  EXPECT_NE(find(s.doubts, DoubtKind::modes_unseen), nullptr) << texts(s.doubts);
}

TEST(Doubts, AShortListWithoutConstantsIsOpenUntilTheModulusIsNarrowed) {
  ModeSet set = measured_modes(1);
  set.modes = {set.modes[3]};
  set.outputs.clear();
  set.form = FrfKind::unknown;
  set.modes[0].modal_constant.resize(0);
  set.modes[0].modal_constant_sigma.resize(0);
  const Study open = study(set);  // any mode of the wire has this frequency at some modulus
  const Doubt* doubt = find(open.doubts, DoubtKind::pairing_open);
  ASSERT_NE(doubt, nullptr) << texts(open.doubts);
  EXPECT_EQ(doubt->count, 1);
  EXPECT_EQ(doubt->of, 1);
  EXPECT_GT(doubt->other, 0.05);
  EXPECT_THAT(sentence(*doubt), HasSubstr("--modulus-range LO:HI"));
  EXPECT_TRUE(question_the_model(open.doubts));
  FitOptions options;  // so near that chance hardly puts a mode there
  options.pairing.modulus_lo = 0.97e11;
  options.pairing.modulus_hi = 1.02e11;
  const Study told = study(set, wire(), options);
  EXPECT_EQ(find(told.doubts, DoubtKind::pairing_open), nullptr) << texts(told.doubts);
  const double modulus = synthetic::true_modulus().at(set.modes[0].natural_frequency_hz);
  EXPECT_NEAR(told.identified.modulus.value[0] / modulus, 1.0, 0.01);  // a frequency 0.1 % off, five sigma
}

TEST(Doubts, TwoModesThatNoLawCanBeChosenByAreNoMatterOfGeometry) {
  ModeSet set = measured_modes(1, 0.0);  // their moduli differ by the slope, 4 %
  set.modes = {set.modes[1], set.modes.back()};
  const Study s = study(set);
  const Doubt* doubt = find(s.doubts, DoubtKind::law_misfit);
  ASSERT_NE(doubt, nullptr) << texts(s.doubts);
  EXPECT_THAT(sentence(*doubt), HasSubstr("--modulus-law power"));
  EXPECT_THAT(sentence(*doubt), Not(HasSubstr("geometry")));
}

// ---- predictions

OutputComparison output(const std::string& name, double frac, double error_db, double noise_share = 0.01) {
  OutputComparison result;
  result.output = name;
  result.frac = frac;
  result.log_magnitude_error_db = error_db;
  result.noise_share = noise_share;
  result.measured_rms = 1.0;
  return result;
}

Comparison comparison(std::vector<OutputComparison> outputs) {
  Comparison result;
  result.outputs = std::move(outputs);
  return result;
}

IdentifiedParameters damped(double rayleigh_rms, double law_rms) {
  IdentifiedParameters identified;
  identified.rayleigh_known = true;
  identified.rayleigh.rms = rayleigh_rms;
  identified.loss_factor.value = Eigen::VectorXd::Constant(6, 0.03);
  LawFit law;
  law.rms = law_rms;
  identified.loss_factor.laws = {law};
  return identified;
}

TEST(Doubts, LowFracIsToldWhereNoiseDoesNotExplainIt) {
  const auto doubts_of = [](const Comparison& both) {
    return comparison_doubts(both, both, {}, damped(20.0, 1.0), {});
  };
  EXPECT_THAT(doubts_of(comparison({output("a", 0.98, 1.0), output("b", 0.91, 2.0)})), IsEmpty());
  EXPECT_THAT(doubts_of(comparison({output("noisy", 0.5, 8.0, 0.45)})), IsEmpty());
  OutputComparison weak = output("cross-talk", 0.1, 20.0);
  weak.measured_rms = 0.05;
  EXPECT_THAT(doubts_of(comparison({output("a", 0.98, 1.0), weak})), IsEmpty());
  const auto low = doubts_of(comparison({output("a", 0.98, 1.0), output("b", 0.27, 15.0)}));
  ASSERT_EQ(low.size(), 1u);
  EXPECT_THAT(sentence(low[0]), HasSubstr("FRAC of b down to 0.27"));
}

TEST(Doubts, ViscousDampingIsSuggestedWhereItIsPlain) {
  const Comparison structural = comparison({output("a", 0.96, 1.0)});
  const Comparison closer = comparison({output("a", 0.99, 0.95)});
  const ModeSet modes;  // read with structural damping
  const auto suggested = comparison_doubts(structural, closer, modes, damped(0.8, 12.0), {});
  ASSERT_EQ(suggested.size(), 1u);
  EXPECT_EQ(suggested[0].kind, DoubtKind::viscous_closer);
  EXPECT_THAT(sentence(suggested[0]), HasSubstr("damping = \"viscous\""));
  EXPECT_FALSE(question_the_model(suggested));
  EXPECT_EQ(
      comparison_doubts(structural, comparison({output("a", 0.99, 0.5)}), modes, damped(5.0, 5.0), {}).size(),
      1u);
  // Little in it, and a constant loss factor as good: no.
  EXPECT_THAT(comparison_doubts(structural, closer, modes, damped(2.0, 1.0), {}), IsEmpty());
  // Already read so; or scene and units in question.
  ModeSet viscous;
  viscous.damping = fem::Damping::viscous;
  EXPECT_THAT(comparison_doubts(structural, closer, viscous, damped(0.8, 12.0), {}), IsEmpty());
  Doubt offset;
  offset.kind = DoubtKind::level_offset;
  EXPECT_THAT(comparison_doubts(structural, closer, modes, damped(0.8, 12.0), {offset}), IsEmpty());
}

TEST(Doubts, OutputsThatAreNotDefinedAreNotDoubted) {
  const Comparison c = comparison({output("a", 0.99, 1.0), output("b", std::nan(""), std::nan(""))});
  EXPECT_THAT(comparison_doubts(c, c, {}, damped(20.0, 1.0), {}), IsEmpty());
}

}  // namespace
}  // namespace struna::ident
