#include "fem/body_number.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

/// d(quantity)/d(diameter) of a solid circle.
BodyNumber diameter(const Body& body) {
  const double d = std::pow(64.0 * body.section.second_moment / (0.25 * M_PI) / 4.0, 0.25);
  BodyNumber number{.name = "diameter", .value = d};
  number.section = {2.0 * body.section.area / d, 4.0 * body.section.second_moment / d,
                    4.0 * body.section.torsion_constant / d};
  return number;
}

TEST(BodyNumber, SlopesOfAStraightWireAreThoseOfTheClosedForm) {
  // lambda = (b L)^4 I/(rho A L^4) for bending.
  const Model model = assemble(testing::straight_wire(), 20);
  const Eigenmodes modes = solve_eigenmodes(model, 8);
  const Body& body = model.body;
  const BodyNumber d = diameter(body);
  const double l = body.centreline.length();
  const BodyNumber length{.name = "length", .value = l, .length = 1.0};
  const BodyNumber density{.name = "density", .value = body.density, .density = 1.0};
  for (int r = 0; r < 8; ++r) {
    // Truncation of the differences, in a length magnified by what cancels in each element.
    EXPECT_NEAR(d.value * log_eigenvalue_slopes(model, modes, d)[r], 2.0, 5e-5);
    EXPECT_NEAR(l * log_eigenvalue_slopes(model, modes, length)[r], -4.0, 5e-5);
    EXPECT_NEAR(body.density * log_eigenvalue_slopes(model, modes, density)[r], -1.0, 1e-6);
    EXPECT_NEAR(body.section.torsion_constant *
                    log_eigenvalue_slopes(model, modes, fittable_number(body, "torsion_constant"))[r],
                0.0, 1e-6);
  }
}

TEST(BodyNumber, SlopesOfACurvedWireAreTheDifferencesOfSolvedModes) {
  Body body = testing::spline_wire();
  body.start_support.rotation = 20.0;
  body.end_support.translation = 1e5;
  body.end_support.mass = 0.002;
  const Model model = assemble(body, 16);
  const Eigenmodes modes = solve_eigenmodes(model, 8);
  for (const char* name : {"torsion_constant", "start.rotation", "end.translation", "end.mass"}) {
    const BodyNumber number = fittable_number(body, name);
    const double step = 1e-4 * number.value;
    const auto log_lambda = [&](double change) {
      return Eigen::ArrayXd(
          solve_eigenmodes(assemble(moved(body, number, change), 16), 8).eigenvalue.array().log());
    };
    const Eigen::ArrayXd solved = (log_lambda(step) - log_lambda(-step)) / (2.0 * step);
    const Eigen::ArrayXd slopes = log_eigenvalue_slopes(model, modes, number).array();
    // Relative to an effect of one per one; the modes' own rounding, 1e-9, over 2e-4.
    EXPECT_LT((slopes - solved).abs().maxCoeff() * number.value, 2e-5) << name;
    EXPECT_GT(slopes.abs().maxCoeff() * number.value, 1e-3) << name;
  }
}

TEST(BodyNumber, MovesWhatItIsNamedAfter) {
  const Body body = testing::straight_wire();
  Body pinned = body;
  pinned.end = EndCondition::pinned;
  const Body both = moved(pinned, BodyNumber{.name = "both.rotation", .value = 5.0}, 1.0);
  EXPECT_EQ(both.start_support.rotation, 6.0);
  EXPECT_EQ(both.end_support.rotation, 6.0);
  EXPECT_EQ(both.end, EndCondition::clamped);
  const Body longer = moved(body, BodyNumber{.name = "length", .value = 0.68, .length = 1.0}, 0.01);
  EXPECT_NEAR(longer.centreline.length(), body.centreline.length() + 0.01, 1e-15);
  EXPECT_EQ(moved(body, fittable_number(body, "torsion_constant"), 1e-13).section.torsion_constant,
            body.section.torsion_constant + 1e-13);
  EXPECT_TRUE(std::isinf(fittable_number(body, "start.translation").value));
}

TEST(BodyNumber, RefusesWhatCannotBeFitted) {
  Body body = testing::straight_wire();
  EXPECT_THROW(fittable_number(body, "diameter"), Error);
  body.end = EndCondition::free;
  EXPECT_THROW(fittable_number(body, "both.rotation"), Error);
  EXPECT_NO_THROW(fittable_number(body, "end.mass"));
  const Model model = assemble(body, 4);
  EXPECT_THROW(
      log_eigenvalue_slopes(model, solve_eigenmodes(model, 1), fittable_number(body, "start.rotation")),
      Error);
}

}  // namespace
}  // namespace struna::fem
