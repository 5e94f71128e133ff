#include "fem/sizing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fem/error.hpp"
#include "tests/fem/bodies.hpp"
#include "tests/fem/rattling_scene.hpp"
#include "tests/fem/sized_scene.hpp"

namespace struna::fem {
namespace {

constexpr double pi = std::numbers::pi;

MeshRequest frequencies_to(double hi_hz, double tolerance) {
  return {.hi_hz = hi_hz, .tolerance = tolerance};
}

MeshRequest response_to(double hi_hz, double tolerance) {
  return {.lo_hz = 10.0, .hi_hz = hi_hz, .tolerance = tolerance, .target = SizingTarget::response};
}

TEST(Sizing, BendingErrorIsThatOfTheStraightBeamsHighModes) {
  const Body body = testing::straight_wire();
  // Wavenumber of clamped mode m times L: (m + 1/2) pi within 1e-5 from the sixth on.
  const double root = 12.5 * pi;
  const double exact = std::pow(root / testing::wire_length, 4) * body.section.second_moment /
                       (body.density * body.section.area);
  const double f_hz = std::sqrt(testing::wire_modulus * exact) / (2.0 * pi);
  for (const int elements : {30, 60, 120}) {
    // Modes come in pairs: the twelfth of a plane is the 23rd and 24th.
    const Eigenmodes modes = solve_eigenmodes(assemble(body, elements), 40);
    double nearest = 1.0;
    for (const double value : modes.eigenvalue)
      nearest = std::min(nearest, std::abs(std::sqrt(value / exact) - 1.0));
    const MeshError estimate = estimate_mesh_error(body, frequencies_to(f_hz, 1e-3), elements);
    // The formula holds for waves; the clamped ends of twelve half-waves take up to 8 %, next orders of (b
    // h)^2 another 4 % at 30 elements.
    EXPECT_NEAR(nearest / estimate.bending, 1.0, 0.12) << elements;
  }
}

TEST(Sizing, StretchErrorIsThatOfLinearElements) {
  // Short enough that torsion and stretch come early: with its waves in the band their error leads.
  Body body = testing::straight_wire();
  const double torsion_hz =
      std::sqrt(testing::wire_modulus / 2.6 / body.density) / (2.0 * testing::wire_length);
  for (const int elements : {40, 80}) {
    const Eigenmodes modes = solve_eigenmodes(assemble(body, elements));
    const Eigen::VectorXd f = natural_frequencies_hz(body, modes.eigenvalue);
    double nearest = 1.0;
    for (const double f_hz : f) nearest = std::min(nearest, std::abs(f_hz / torsion_hz - 1.0));
    const MeshError estimate = estimate_mesh_error(body, frequencies_to(1.05 * torsion_hz, 1e-3), elements);
    EXPECT_NEAR(nearest / estimate.stretch, 1.0, 0.01) << elements;  // next order (k h)^2/30
    EXPECT_EQ(estimate_mesh_error(body, frequencies_to(0.95 * torsion_hz, 1e-3), elements).stretch, 0.0);
  }
}

TEST(Sizing, TakesTheFewestElementsWithinTheTolerance) {
  for (const Body& body : {testing::straight_wire(), testing::arc_wire(90.0), testing::spline_wire()}) {
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      for (const MeshRequest& request : {frequencies_to(1000.0, tolerance), response_to(1000.0, tolerance)}) {
        const MeshChoice choice = choose_mesh(body, request);
        if (choice.reason == MeshReason::limit || choice.reason == MeshReason::turn) continue;
        EXPECT_TRUE(choice.within());
        EXPECT_GT(estimate_mesh_error(body, request, choice.elements - 1).total(), tolerance);
        EXPECT_DOUBLE_EQ(estimate_mesh_error(body, request, choice.elements).total(), choice.error.total());
      }
    }
  }
}

TEST(Sizing, LeastAndTurnsBindWhereTheBandAsksForLittle) {
  const MeshChoice straight = choose_mesh(testing::straight_wire(), frequencies_to(1.0, 1e-2));
  EXPECT_EQ(straight.elements, 6);
  EXPECT_EQ(straight.reason, MeshReason::least);
  const MeshChoice ring = choose_mesh(testing::arc_wire(350.0), frequencies_to(1.0, 1e-2));
  EXPECT_EQ(ring.elements, 8);  // of 45 degrees
  EXPECT_EQ(ring.reason, MeshReason::turn);
  MeshRequest contact = frequencies_to(1.0, 1e-2);
  contact.contact = true;
  EXPECT_EQ(choose_mesh(testing::straight_wire(), contact).elements, 8);
  EXPECT_EQ(choose_mesh(testing::arc_wire(179.9), contact).elements, 18);  // of 10 degrees
}

TEST(Sizing, GivenElementsStayAndAreJudged) {
  Body body = testing::straight_wire();
  body.elements = 12;
  const MeshChoice choice = choose_mesh(body, frequencies_to(1000.0, 1e-3));
  EXPECT_EQ(choice.elements, 12);
  EXPECT_EQ(choice.reason, MeshReason::given);
  EXPECT_FALSE(choice.within());
  EXPECT_GT(choice.error.total(), 1e-3);
}

TEST(Sizing, ATolerancePastRoundingIsToldToBeOutOfReach) {
  const MeshChoice choice = choose_mesh(testing::straight_wire(), frequencies_to(3000.0, 1e-9));
  EXPECT_EQ(choice.reason, MeshReason::limit);
  EXPECT_FALSE(choice.within());
  EXPECT_LT(choice.elements, 1000);
  // Rounding has taken a good part of it by then: finer would be worse.
  EXPECT_GT(choice.error.rounding, 0.2 * choice.error.total());
}

TEST(Sizing, LightDampingAsksForMoreElementsOfAResponse) {
  Body body = testing::straight_wire();
  const auto elements = [&](double loss_factor) {
    body.material.loss_factor = constant_law(loss_factor);
    return choose_mesh(body, response_to(500.0, 1e-3)).elements;
  };
  // Errors at a resonance are 2/eta times those of its frequency: 10 times less damping asks for 10^(1/4)
  // times as many, a little less for what does not depend on damping.
  EXPECT_NEAR(static_cast<double>(elements(0.001)) / elements(0.01), std::pow(10.0, 0.25), 0.05);
  EXPECT_GT(elements(0.0), 0);  // undamped: as for 0.001
  EXPECT_EQ(elements(0.0), elements(0.001));
}

TEST(Sizing, RefusesWhatHasNoAnswer) {
  const Body body = testing::straight_wire();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    MeshRequest request;
    const char* what;
  };
  for (const Case& tried :
       {Case{frequencies_to(0.0, 1e-4), "highest frequency"},
        Case{frequencies_to(nan, 1e-4), "highest frequency"}, Case{frequencies_to(100.0, 0.0), "tolerance"},
        Case{frequencies_to(100.0, 1.5), "tolerance"}, Case{frequencies_to(100.0, nan), "tolerance"},
        Case{response_to(5.0, 1e-3), "lowest frequency"}, Case{frequencies_to(1e15, 1e-6), "1000"}}) {
    try {
      choose_mesh(body, tried.request);
      ADD_FAILURE() << tried.what << ": not refused";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(tried.what));
    }
  }
  EXPECT_THROW(estimate_mesh_error(body, frequencies_to(100.0, 1e-3), 0), Error);
}

TEST(Sizing, RefinementFollowsTheOrderAndStopsAtFourTimes) {
  EXPECT_EQ(refined_elements(40, 16e-3 / 1.1, 1e-3, true), 80);
  EXPECT_EQ(refined_elements(40, 1.0, 1e-6, true), 160);
  EXPECT_EQ(refined_elements(40, 1e-5, 1e-3, true), 40);
  EXPECT_GT(refined_elements(40, 16e-3, 1e-3, false), refined_elements(40, 16e-3, 1e-3, true));
  EXPECT_EQ(refined_elements(900, 1.0, 1e-6, true), 1000);
  EXPECT_DOUBLE_EQ(error_from_difference(1.0, true), 16.0 / 15.0);
  EXPECT_DOUBLE_EQ(error_from_difference(1.0, false), 4.0 / 3.0);
}

TEST(Sizing, NarrowestBandwidthIsThatOfTheFirstModeInTheBand) {
  const Body body = testing::straight_wire();
  const Eigen::VectorXd f = natural_frequencies_hz(body, solve_eigenmodes(assemble(body, 60), 12).eigenvalue);
  // The estimate's mesh is 3 % off at the band's end and less below.
  EXPECT_NEAR(narrowest_bandwidth_hz(body, Damping::structural, 1.0, 500.0), 0.02 * f(0), 0.01 * 0.02 * f(0));
  EXPECT_NEAR(narrowest_bandwidth_hz(body, Damping::structural, 1.1 * f(1), 500.0), 0.02 * f(2),
              0.01 * 0.02 * f(2));
  EXPECT_EQ(narrowest_bandwidth_hz(body, Damping::structural, 1.1 * f(0), 0.9 * f(2)), 0.0);
}

TEST(Sizing, BeamTheoryErrorIsThatOfTimoshenkosBeam) {
  // Pinned beam: w^2 from Timoshenko's frequency equation for a wave sin(b x) (Timoshenko 1921),
  //   b^4 (E I/(rho A)) - w^2 (1 + b^2 r^2 (1 + E/(kappa G))) + (rho r^2/(kappa G)) w^4 = 0.
  Body body = testing::straight_wire();
  const double modulus = testing::wire_modulus;
  const double r2 = body.section.second_moment / body.section.area;
  const double ratio =
      2.0 * 1.3 / (6.0 * 1.3 / (7.0 + 6.0 * 0.3));  // E/(kappa G), Cowper's kappa of a circle
  for (const double slenderness : {40.0, 80.0}) {   // wavelength over diameter / 2 pi
    const double b = 1.0 / (slenderness * 0.0032) * 2.0 * pi;
    const double euler = b * b * b * b * modulus * r2 / body.density;  // w^2
    const double beta = 1.0 + b * b * r2 * (1.0 + ratio);
    const double gamma = body.density * r2 * ratio / modulus;
    const double exact = (beta - std::sqrt(beta * beta - 4.0 * gamma * euler)) / (2.0 * gamma);
    const double f_euler = std::sqrt(euler) / (2.0 * pi);
    const double error = std::sqrt(euler / exact) - 1.0;
    // First order: the next is (b r)^4 times some 20, 2 % of the first here.
    EXPECT_NEAR(beam_theory_error(body, f_euler) / error, 1.0, 0.03) << slenderness;
  }
}

// The first six of the benchmark's random scenes that are small; 200 of all sizes are in
// tests/bench/sizing_bench.cpp.
TEST(Sizing, KeepsToleranceInRandomScenesAtNoMoreThanTwiceTheElements) {
  int outside = 0, costly = 0;
  for (unsigned seed = 1, scenes = 0; scenes < 6; ++seed) {
    const testing::RandomScene scene = testing::random_scene(seed);
    if (choose_mesh(scene.body, frequencies_to(scene.hi_hz, scene.tolerance)).elements > 25) continue;
    ++scenes;
    const testing::SizedScene sized = testing::size_scene(scene);
    ASSERT_LT(sized.frequency.reference_error, 0.1) << "reference of seed " << seed;
    ASSERT_LT(sized.response.reference_error, 0.1) << "reference of seed " << seed;
    for (const auto& outcome : {sized.frequency, sized.response}) {
      outside += outcome.error > 1.0 ? 1 : 0;
      costly += outcome.elements > 2 * outcome.fewest ? 1 : 0;
      EXPECT_LT(outcome.error, 2.0) << "seed " << seed;
    }
  }
  EXPECT_LE(outside, 1);
  EXPECT_LE(costly, 1);
}

// The first of the benchmark's 40 rattling wires.
TEST(Sizing, KeepsToleranceOfARandomRattlingWire) {
  for (const unsigned seed : {1U}) {
    const testing::SizedRun run = testing::size_run(testing::random_rattling_scene(seed), false);
    EXPECT_LT(run.reference_error, 0.3) << "reference of seed " << seed;
    EXPECT_LT(run.error, 1.0) << "seed " << seed;
    EXPECT_GT(run.choice.checked_until, run.choice.checked_from);
  }
}

}  // namespace
}  // namespace struna::fem
