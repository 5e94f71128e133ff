// Numbers of the body fitted beside the modulus law: recovered within their errors where the modes tell them,
// declared where they do not.
#include "ident/joint_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "tests/ident/stated_wire.hpp"

namespace struna::ident {
namespace {

using stated::Wire;

constexpr unsigned runs = 5;
const fem::FrequencyLaw level = fem::constant_law(1e11);

/// A stiffness of turning whose compliance is EI/(kL) = c.
double turning(const Wire& wire, double compliance) {
  return 1e11 * wire.body.section.second_moment / (compliance * wire.body.centreline.length());
}

FitOptions free_numbers(const std::vector<std::string>& names, const std::string& law) {
  FitOptions options = stated::bare();
  options.modulus_law = law;
  options.free = names;
  return options;
}

struct Scatter {
  double squares = 0.0;
  double largest = 0.0;
  int runs = 0;

  void add(double deviation) {
    squares += deviation * deviation;
    largest = std::max(largest, std::abs(deviation));
    ++runs;
  }
  double rms() const { return std::sqrt(squares / runs); }
};

TEST(JointFit, TorsionConstantOfACurvedWireIsRecoveredWithinItsError) {
  const Wire scene = stated::wire(true);
  Wire truth = scene;
  truth.body.section.torsion_constant *= 0.6;
  Scatter torsion, modulus;
  for (unsigned seed = 1; seed <= runs; ++seed) {
    const ModeSet modes = stated::measured(truth, synthetic::true_modulus(), 300.0, 3e-4, seed);
    const IdentifiedParameters p = stated::fitted(modes, scene, free_numbers({"torsion_constant"}, "power"));
    ASSERT_EQ(p.fitted.name.size(), 1u)
        << (p.fitted.inseparable.empty() ? "" : p.fitted.inseparable[0].reason);
    EXPECT_LT(p.fitted.sigma()[0], 0.1 * p.fitted.value[0]);
    EXPECT_GT(p.fitted.condition, 1.0);
    torsion.add((p.fitted.value[0] - truth.body.section.torsion_constant) / p.fitted.sigma()[0]);
    const fem::FrequencyLaw& law = p.modulus.laws.front().law;
    const double sigma =
        std::hypot(law_sigma(p.modulus.laws.front(), 80.0), law_sigma(law, p.errors, true, 80.0));
    modulus.add((law.at(80.0) - synthetic::true_modulus().at(80.0)) / sigma);
  }
  // Five normal deviations: an rms of 1 +- 0.32, the largest below 3.5.
  for (const Scatter& scatter : {torsion, modulus}) {
    EXPECT_NEAR(scatter.rms(), 1.0, 0.85);
    EXPECT_LT(scatter.largest, 3.5);
  }
}

TEST(JointFit, TorsionConstantOfAStraightWireIsDeclaredInseparable) {
  const Wire wire = stated::wire(false);
  const ModeSet modes = stated::measured(wire, level, 600.0, 3e-4, 1);
  const IdentifiedParameters p = stated::fitted(modes, wire, free_numbers({"torsion_constant"}, "constant"));
  EXPECT_TRUE(p.fitted.name.empty());
  ASSERT_EQ(p.fitted.inseparable.size(), 1u);
  EXPECT_NE(p.fitted.inseparable[0].reason.find("hardly depend on it"), std::string::npos)
      << p.fitted.inseparable[0].reason;
  EXPECT_EQ(apply(p, wire.body).section.torsion_constant, wire.body.section.torsion_constant);
}

TEST(JointFit, TurningSupportsAreRecoveredWithinTheirErrorBesideAConstantModulus) {
  const Wire scene = stated::wire(false);
  Wire truth = scene;
  const double stiffness = turning(scene, 0.02);
  truth.body.start_support.rotation = truth.body.end_support.rotation = stiffness;
  Scatter support, modulus;
  for (unsigned seed = 1; seed <= runs; ++seed) {
    const ModeSet modes = stated::measured(truth, level, 700.0, 3e-4, seed);
    const IdentifiedParameters p = stated::fitted(modes, scene, free_numbers({"both.rotation"}, "constant"));
    ASSERT_EQ(p.fitted.name.size(), 1u)
        << (p.fitted.inseparable.empty() ? "" : p.fitted.inseparable[0].reason);
    support.add((p.fitted.value[0] - stiffness) / p.fitted.sigma()[0]);
    const LawFit& law = p.modulus.laws.front();
    modulus.add((law.law.at(80.0) - 1e11) /
                std::hypot(law_sigma(law, 80.0), law_sigma(law.law, p.errors, true, 80.0)));
    EXPECT_EQ(apply(p, scene.body).end_support.rotation, p.fitted.value[0]);
  }
  for (const Scatter& scatter : {support, modulus}) {
    EXPECT_NEAR(scatter.rms(), 1.0, 0.85);
    EXPECT_LT(scatter.largest, 3.5);
  }
}

TEST(JointFit, TurningSupportsAreDeclaredInseparableFromAFreerModulusOverFewModes) {
  const Wire scene = stated::wire(false);
  Wire truth = scene;
  truth.body.start_support.rotation = truth.body.end_support.rotation = turning(scene, 0.003);
  const ModeSet modes = stated::measured(truth, level, 300.0, 3e-4, 1);
  ASSERT_GE(modes.modes.size(), 4u);
  const IdentifiedParameters p = stated::fitted(modes, scene, free_numbers({"both.rotation"}, "power"));
  EXPECT_TRUE(p.fitted.name.empty());
  ASSERT_EQ(p.fitted.inseparable.size(), 1u);
  EXPECT_NE(p.fitted.inseparable[0].reason.find("as the modulus law"), std::string::npos)
      << p.fitted.inseparable[0].reason;
  EXPECT_GT(p.fitted.condition, 20.0);
  EXPECT_EQ(apply(p, scene.body).start_support.rotation, scene.body.start_support.rotation);
}

TEST(JointFit, BothEndsOfAStraightWireAreOneNumber) {
  const Wire scene = stated::wire(false);
  Wire truth = scene;
  truth.body.start_support.rotation = truth.body.end_support.rotation = turning(scene, 0.02);
  const ModeSet modes = stated::measured(truth, level, 700.0, 3e-4, 1);
  const IdentifiedParameters p =
      stated::fitted(modes, scene, free_numbers({"start.rotation", "end.rotation"}, "constant"));
  EXPECT_EQ(p.fitted.inseparable.size(), 1u);
}

TEST(JointFit, ShiftingSupportsOfACurvedWireAreRecovered) {
  const Wire scene = stated::wire(true);
  Wire truth = scene;
  const double length = truth.body.centreline.length();
  truth.body.start_support.translation = turning(scene, 1e-3) / (length * length);
  const ModeSet modes = stated::measured(truth, level, 300.0, 3e-4, 3);
  const IdentifiedParameters p =
      stated::fitted(modes, scene, free_numbers({"start.translation"}, "constant"));
  ASSERT_EQ(p.fitted.name.size(), 1u) << (p.fitted.inseparable.empty() ? "" : p.fitted.inseparable[0].reason);
  EXPECT_NEAR(p.fitted.value[0], truth.body.start_support.translation, 3.5 * p.fitted.sigma()[0]);
  EXPECT_LT(p.fitted.sigma()[0], 0.3 * p.fitted.value[0]);
}

TEST(JointFit, StatedSupportsGiveTheTrueModulus) {
  Wire wire = stated::wire(false);
  wire.body.start_support.rotation = wire.body.end_support.rotation = turning(wire, 0.02);
  const ModeSet modes = stated::measured(wire, level, 400.0, 0.0, 1);
  const IdentifiedParameters p = stated::fitted(modes, wire, stated::bare());
  EXPECT_LT((p.modulus.value.array() / 1e11 - 1.0).abs().maxCoeff(), 1e-9);  // rounding of the eigenvalues
  Wire rigid = wire;
  rigid.body.start_support = rigid.body.end_support = {};
  const IdentifiedParameters wrong = stated::fitted(modes, rigid, stated::bare());
  EXPECT_LT(wrong.modulus.value.maxCoeff(), 0.9e11);  // four times 0.02 per end
}

TEST(JointFit, RefusesWhatItCannotFit) {
  const Wire wire = stated::wire(false);
  const ModeSet modes = stated::measured(wire, level, 300.0, 1e-4, 1);
  const auto refusal = [&](const std::vector<std::string>& names, const std::string& law) {
    try {
      stated::fitted(modes, wire, free_numbers(names, law));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal({"diameter"}, "constant").find("can be fitted"), std::string::npos);
  EXPECT_NE(refusal({"both.rotation", "end.rotation"}, "constant").find("one number"), std::string::npos);
  EXPECT_NE(refusal({"both.rotation"}, "monotone_spline").find("constant or a power law"), std::string::npos);
  EXPECT_EQ(refusal({}, "constant"), "");
}

}  // namespace
}  // namespace struna::ident
