#include "fem/body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

TEST(Body, SectionsMeetTheirClosedForms) {
  const Section wire = solid_circle(0.0032);
  EXPECT_NEAR(wire.area, 8.042477193189871e-6, 1e-20);
  EXPECT_NEAR(wire.second_moment, std::numbers::pi * std::pow(0.0032, 4) / 64.0, 1e-27);
  EXPECT_DOUBLE_EQ(wire.torsion_constant, 2.0 * wire.second_moment);
  const Section band = ring(0.0095, 0.0035);
  EXPECT_NEAR(band.second_moment, 3.9245e-10, 2e-14);  // published to five digits
  EXPECT_NEAR(band.area, std::numbers::pi / 4.0 * (0.0095 * 0.0095 - 0.0035 * 0.0035), 1e-18);
  EXPECT_THROW(solid_circle(0.0), Error);
  EXPECT_THROW(solid_circle(-1.0), Error);
  EXPECT_THROW(ring(0.003, 0.003), Error);
  EXPECT_THROW(ring(0.003, 0.0), Error);
}

TEST(Body, ASoundOneIsAccepted) {
  EXPECT_NO_THROW(validate(testing::spline_wire()));
}

TEST(Body, EveryUnsoundFieldIsRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  struct Case {
    const char* field;
    std::function<void(Body&)> spoil;
  };
  const std::vector<Case> cases = {
      {"name", [](Body& b) { b.name.clear(); }},
      {"area", [](Body& b) { b.section.area = 0.0; }},
      {"area", [nan](Body& b) { b.section.area = nan; }},
      {"second_moment", [](Body& b) { b.section.second_moment = -1e-12; }},
      {"second_moment", [inf](Body& b) { b.section.second_moment = inf; }},
      {"torsion_constant", [](Body& b) { b.section.torsion_constant = 0.0; }},
      {"density", [](Body& b) { b.density = 0.0; }},
      {"density", [nan](Body& b) { b.density = nan; }},
      {"poisson", [](Body& b) { b.poisson = 0.6; }},
      {"poisson", [](Body& b) { b.poisson = -1.0; }},
      {"poisson", [nan](Body& b) { b.poisson = nan; }},
      {"elements", [](Body& b) { b.elements = -1; }},
      {"youngs_modulus", [](Body& b) { b.material.youngs_modulus = constant_law(0.0); }},
      {"youngs_modulus",
       [](Body& b) { b.material.youngs_modulus = {FrequencyLaw::Kind::power, {1e11}, {}, {}, 0.0, 0.0}; }},
      {"loss_factor", [](Body& b) { b.material.loss_factor = constant_law(-0.1); }},
      {"alpha", [](Body& b) { b.material.rayleigh.alpha = -1.0; }},
      {"beta", [nan](Body& b) { b.material.rayleigh.beta = nan; }},
  };
  for (const Case& c : cases) {
    Body body = testing::straight_wire();
    c.spoil(body);
    try {
      validate(body);
      FAIL() << c.field << " was accepted";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(c.field), std::string::npos) << error.what();
    }
  }
}

TEST(Body, TheModulusMayBeUnknownUntilItIsNeeded) {
  Body body = testing::straight_wire();
  EXPECT_NO_THROW(validate_modulus(body));
  body.material.youngs_modulus = {};
  EXPECT_NO_THROW(validate(body));
  EXPECT_THROW(validate_modulus(body), Error);
  EXPECT_THROW(recommended_elements(body, 100.0, 1e-4), Error);
}

TEST(Body, RecommendedElementsKeepTheHermiteErrorBelowTheTolerance) {
  const Body body = testing::straight_wire();
  for (const double tolerance : {1e-3, 1e-4, 1e-5}) {
    // The sixth pair lies at 454.7 Hz.
    const int elements = recommended_elements(body, 455.0, tolerance);
    const Eigenmodes modes = solve_eigenmodes(assemble(body, elements), 12);
    const double root = 20.42035224562606;
    const double exact = std::pow(root / testing::wire_length, 4) * body.section.second_moment /
                         (body.density * body.section.area);
    const double error = std::sqrt(modes.eigenvalue(10) / exact) - 1.0;
    EXPECT_LT(error, tolerance);
    EXPECT_GT(error, 0.3 * tolerance) << "more elements than needed";
  }
}

TEST(Body, RecommendedElementsAreAtLeastSixAndFollowTheCurve) {
  EXPECT_EQ(recommended_elements(testing::straight_wire(), 1.0, 1e-3), 6);
  EXPECT_EQ(recommended_elements(testing::arc_wire(359.0), 1.0, 1e-3), 8);  // 45 degrees each
}

TEST(Body, RecommendedElementsRefuseWhatHasNoAnswer) {
  const Body body = testing::straight_wire();
  EXPECT_THROW(recommended_elements(body, 0.0, 1e-4), Error);
  EXPECT_THROW(recommended_elements(body, 100.0, 0.0), Error);
  EXPECT_THROW(recommended_elements(body, 100.0, 1.5), Error);
  EXPECT_THROW(recommended_elements(body, 1e15, 1e-6), Error);
}

}  // namespace
}  // namespace struna::fem
