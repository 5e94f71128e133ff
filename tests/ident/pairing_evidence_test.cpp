// How probable a pairing is against chance: closed forms, and what must not change it.
#include "ident/pairing_evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "synthetic_wire.hpp"

namespace struna::ident {
namespace {

using synthetic::Wire;

constexpr double tolerance = 0.012;

synthetic::Measured measured(const Wire& wire) {
  synthetic::Flaws flaws;
  flaws.missing = flaws.doubled = flaws.spurious = 0.0;
  return synthetic::measure(wire, flaws, 1);
}

PairingCost::Law true_law(const PairingCost& cost) {
  return {std::log(synthetic::true_modulus().at(std::exp(cost.reference_ln_f()))), 0.02, false};
}

TEST(PairingEvidence, ChanceOfAnAngleIsTheShareOfTheSphere) {
  constexpr double pi = std::numbers::pi;
  for (const double angle : {0.0, 0.1, 1.0, 2.5, pi}) {
    EXPECT_NEAR(chance_of_angle(angle, 2), angle / pi, 1e-15);                     // rounding
    EXPECT_NEAR(chance_of_angle(angle, 3), 0.5 * (1.0 - std::cos(angle)), 1e-15);  // cap of a sphere
    EXPECT_NEAR(chance_of_angle(angle, 4), (angle - 0.5 * std::sin(2 * angle)) / pi, 1e-15);
  }
  for (int dimensions = 2; dimensions <= 9; ++dimensions)
    EXPECT_NEAR(chance_of_angle(0.5 * pi, dimensions), 0.5, 1e-14) << dimensions;  // half of them
}

TEST(PairingEvidence, IsNothingWithoutPairs) {
  const Wire wire = synthetic::curved_wire();
  const auto modes = measured(wire);
  const PairingCost cost(modes.set, wire.modes, {});
  EXPECT_EQ(pairing_evidence(cost, true_law(cost), std::vector<int>(modes.set.modes.size(), -1), {}), 0.0);
}

TEST(PairingEvidence, FallsWithEveryPairThatIsLeftOutAndWithTheModulusOff) {
  const Wire wire = synthetic::curved_wire();
  const auto modes = measured(wire);
  const PairingCost cost(modes.set, wire.modes, {});
  const PairingCost::Law law = true_law(cost);
  const auto assignment = cost.assign(law, tolerance);
  const double whole = pairing_evidence(cost, law, assignment.explanation, {});
  EXPECT_GT(whole, 60.0);  // each of a dozen pairs is worth some ten
  for (std::size_t i = 0; i < assignment.explanation.size(); ++i) {
    if (assignment.explanation[i] < 0) continue;
    std::vector<int> without = assignment.explanation;
    without[i] = -1;
    EXPECT_LT(pairing_evidence(cost, law, without, {}), whole - 2.0) << i;
  }
  for (const double off : {-0.03, 0.03}) {
    const PairingCost::Law other{law.ln_modulus + off, law.slope, false};
    EXPECT_LT(pairing_evidence(cost, other, assignment.explanation, {}), whole) << off;
  }
}

TEST(PairingEvidence, ANarrowerRangeOfTheModulusAddsTheLogarithmOfItsShare) {
  const Wire wire = synthetic::curved_wire();
  const auto modes = measured(wire);
  const PairingOptions wide, narrow{.modulus_lo = 1e10, .modulus_hi = 1e12};
  const PairingCost cost(modes.set, wire.modes, wide);
  const PairingCost::Law law = true_law(cost);
  const auto assignment = cost.assign(law, tolerance);
  EXPECT_NEAR(pairing_evidence(cost, law, assignment.explanation, narrow) -
                  pairing_evidence(cost, law, assignment.explanation, wide),
              std::log(6.0 / 2.0), 1e-12);  // decades; rounding
}

}  // namespace
}  // namespace struna::ident
