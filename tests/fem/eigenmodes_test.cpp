#include "fem/eigenmodes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/closed_forms.hpp"
#include "fem/error.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd frequencies(const Body& body, int elements, int count) {
  const Eigenmodes modes = solve_eigenmodes(assemble(body, elements), count);
  VectorXd f(count);
  for (int r = 0; r < count; ++r)
    f(r) = natural_frequency_hz(modes.eigenvalue(r), body.material.youngs_modulus);
  return f;
}

/// (b L/n)^4/1440 with b^4 = rho A w^2/(E I).
double hermite_error(const Body& body, double f_hz, int elements) {
  const double omega = 2.0 * std::numbers::pi * f_hz;
  const double wave4 = body.density * body.section.area * omega * omega /
                       (body.material.youngs_modulus.at(f_hz) * body.section.second_moment);
  return wave4 * std::pow(body.centreline.length() / elements, 4) / 1440.0;
}

ClampedBeam clamped_beam(const Body& body) {
  return {body.centreline.length(), testing::wire_modulus * body.section.second_moment,
          body.density * body.section.area};
}

TEST(Eigenmodes, StraightWireMeetsTheHermiteErrorTwoSided) {
  const Body body = testing::straight_wire();
  const VectorXd f = frequencies(body, 28, 12);
  // Measured over formula, independently computed; the next term of the series makes it fall below one.
  const double ratio[] = {0.9996, 0.9983, 0.9964, 0.9938, 0.9905, 0.9865};
  for (int mode = 1; mode <= 6; ++mode) {
    const double exact = natural_frequency_hz(clamped_beam(body), mode);
    const double formula = std::pow(clamped_clamped_root(mode) / 28.0, 4) / 1440.0;
    for (const int plane : {0, 1}) {
      EXPECT_NEAR((f(2 * (mode - 1) + plane) / exact - 1.0) / formula, ratio[mode - 1], 5e-4)
          << mode;  // rounding 1e-10
    }
  }
}

TEST(Eigenmodes, StraightWireConvergesAtFourthOrderTwoSided) {
  const Body body = testing::straight_wire();
  const VectorXd coarse = frequencies(body, 14, 8);
  const VectorXd fine = frequencies(body, 28, 8);
  for (int r = 0; r < 8; ++r) {
    const double exact = natural_frequency_hz(clamped_beam(body), r / 2 + 1);
    EXPECT_NEAR(std::log2((coarse(r) / exact - 1.0) / (fine(r) / exact - 1.0)), 4.0, 0.04);
  }
}

struct ArcReference {
  double degrees;
  std::vector<double> in_plane;
  std::vector<double> out_of_plane;
};

// Exact: 6 x 6 constant-coefficient state matrices in 40 digits.
const ArcReference arcs[] = {
    {60.0,
     {64.268972046635, 118.73629870357, 214.49447000729, 312.07413768829, 451.08878739467},
     {23.428528580782, 65.822260679123, 130.25623090046, 216.27479710021, 323.85410231981}},
    {90.0,
     {60.879271443323, 116.30321506381, 210.49928150468, 310.04867407508, 446.87774693064},
     {22.465804745291, 64.127395714096, 128.30995570012, 214.19768576628, 321.6975772154}},
    {180.0,
     {47.189006159706, 103.86231704488, 192.86649668385, 296.09622405461, 428.19324686155},
     {19.582141558985, 56.515035929773, 118.65605410334, 203.51131677032, 310.4059735759}},
};

TEST(Eigenmodes, ArcsMeetTheExactFrequenciesToOneInAMillion) {
  for (const ArcReference& arc : arcs) {
    std::vector<double> exact = arc.in_plane;
    exact.insert(exact.end(), arc.out_of_plane.begin(), arc.out_of_plane.end());
    std::sort(exact.begin(), exact.end());
    const VectorXd f = frequencies(testing::arc_wire(arc.degrees), 112, 10);
    for (int r = 0; r < 10; ++r)
      EXPECT_NEAR(f(r) / exact[r], 1.0, 1e-6) << arc.degrees << " degrees, mode " << r + 1;
  }
}

TEST(Eigenmodes, ArcsConvergeAtFourthOrderTwoSided) {
  for (const ArcReference& arc : arcs) {
    std::vector<double> exact = arc.in_plane;
    exact.insert(exact.end(), arc.out_of_plane.begin(), arc.out_of_plane.end());
    std::sort(exact.begin(), exact.end());
    const VectorXd coarse = frequencies(testing::arc_wire(arc.degrees), 20, 6);
    const VectorXd fine = frequencies(testing::arc_wire(arc.degrees), 40, 6);
    for (int r = 0; r < 6; ++r) {
      EXPECT_NEAR(std::log2((coarse(r) / exact[r] - 1.0) / (fine(r) / exact[r] - 1.0)), 4.0,
                  0.2);  // rounding of the fine mesh
    }
  }
}

TEST(Eigenmodes, ArcModesKeepToTheirPlanes) {
  const ArcReference& arc = arcs[1];
  const Model model = assemble(testing::arc_wire(arc.degrees), 28);
  const Eigenmodes modes = solve_eigenmodes(model, 10);
  std::vector<double> in_plane;
  std::vector<double> out_of_plane;
  for (int r = 0; r < 10; ++r) {
    double along_z = 0.0;
    double along_xy = 0.0;
    for (int node = 0; node <= 28; ++node) {
      along_xy += modes.shape.col(r).segment<2>(6 * node).squaredNorm();
      along_z += std::pow(modes.shape(6 * node + 2, r), 2);
    }
    EXPECT_LT(std::min(along_z, along_xy), 1e-12 * std::max(along_z, along_xy));  // a plane curve decouples
    (along_z > along_xy ? out_of_plane : in_plane)
        .push_back(natural_frequency_hz(modes.eigenvalue(r), constant_law(120e9)));
  }
  ASSERT_EQ(in_plane.size(), 5u);
  for (std::size_t m = 0; m < 5; ++m) {
    EXPECT_NEAR(in_plane[m] / arc.in_plane[m], 1.0, 2e-4);
    EXPECT_NEAR(out_of_plane[m] / arc.out_of_plane[m], 1.0, 2e-4);
  }
}

TEST(Eigenmodes, SplineWireOfThirtyElementsEarnsTheHermiteDigits) {
  // Straight elements extrapolated twice to h -> 0; nine to ten digits.
  const double reference[] = {23.8954350,  36.5733256, 60.2997005, 123.2074663, 127.7125593, 211.1996774,
                              212.1891522, 319.517012, 320.198676, 449.660466,  450.233816,  600.622428};
  const Body body = testing::spline_wire();
  const VectorXd f = frequencies(body, 30, 12);
  for (int r = 0; r < 12; ++r) {
    const double error = f(r) / reference[r] - 1.0;
    if (r < 3) {
      EXPECT_LT(std::abs(error), 1e-5);
    }
    EXPECT_GT(error, 0.9 * hermite_error(body, reference[r], 30));
    EXPECT_LT(error,
              1.02 * hermite_error(body, reference[r], 30));  // geometry costs nothing; the demand is 1.5
  }
}

TEST(Eigenmodes, FreeCurvedBodiesHaveSixRigidModes) {
  Body body = testing::spline_wire();
  body.start = EndCondition::free;
  body.end = EndCondition::free;
  const Eigenmodes modes = solve_eigenmodes(assemble(body, 20));
  for (int r = 0; r < 6; ++r)
    EXPECT_LT(std::abs(modes.eigenvalue(r)), 1e-6 * modes.eigenvalue(6));  // rounding
  EXPECT_GT(modes.eigenvalue(6), 0.1 * clamped_eigenvalue(body));
}

TEST(Eigenmodes, FreeStraightBodyHasTheClampedFrequencies) {
  // Free-free and clamped-clamped beams share cos x cosh x = 1.
  Body body = testing::straight_wire();
  body.start = EndCondition::free;
  body.end = EndCondition::free;
  const VectorXd f = frequencies(body, 28, 10);
  EXPECT_NEAR(f(6) / natural_frequency_hz(clamped_beam(body), 1), 1.0, 1e-6);
  EXPECT_NEAR(f(9) / natural_frequency_hz(clamped_beam(body), 2), 1.0, 1e-5);
}

TEST(Eigenmodes, PinnedEndsGiveSineModes) {
  Body body = testing::straight_wire();
  body.start = EndCondition::pinned;
  body.end = EndCondition::pinned;
  // A pinned body turns freely about its own axis: one rigid mode, then pairs at x = m pi.
  const VectorXd f = frequencies(body, 28, 5);
  const double unit =
      std::sqrt(testing::wire_modulus * body.section.second_moment / (body.density * body.section.area)) *
      std::numbers::pi / (2.0 * testing::wire_length * testing::wire_length);
  EXPECT_LT(f(0), 1e-2);
  for (int m = 1; m <= 2; ++m) {
    for (const int plane : {0, 1}) EXPECT_NEAR(f(2 * m - 1 + plane) / (unit * m * m), 1.0, 1e-5);
  }
}

TEST(Eigenmodes, ModesAreOrthogonalAndMassNormalised) {
  const Model model = assemble(testing::spline_wire(), 12);
  const Eigenmodes modes = solve_eigenmodes(model);
  const long n = modes.eigenvalue.size();
  ASSERT_EQ(n, 66);
  const Eigen::MatrixXd mass = modes.shape.transpose() * multiply(model.mass, modes.shape);
  EXPECT_LT((mass - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-11);
  const Eigen::MatrixXd stiffness = modes.shape.transpose() * multiply(model.stiffness, modes.shape);
  const double top = modes.eigenvalue(n - 1);
  EXPECT_LT((stiffness - Eigen::MatrixXd(modes.eigenvalue.asDiagonal())).cwiseAbs().maxCoeff(), 1e-11 * top);
}

TEST(Eigenmodes, FewModesOfAFineMeshAgreeWithAllOfThem) {
  for (const EndCondition end : {EndCondition::clamped, EndCondition::free}) {
    Body body = testing::straight_wire();  // every bending mode is double
    body.end = end;
    const Model model = assemble(body, 30);
    const Eigenmodes all = solve_eigenmodes(model);
    const Eigenmodes few = solve_eigenmodes(model, 10);
    ASSERT_EQ(few.eigenvalue.size(), 10);
    for (int r = 0; r < 10; ++r)
      EXPECT_NEAR(few.eigenvalue(r) / all.eigenvalue(r), 1.0, 1e-8);  // rounding, n^4
    const Eigen::MatrixXd gram = few.shape.transpose() * multiply(model.mass, few.shape);
    EXPECT_LT((gram - Eigen::MatrixXd::Identity(10, 10)).norm(), 1e-10);
    // Residual of each pair.
    const Eigen::MatrixXd residual =
        multiply(model.stiffness, few.shape) - multiply(model.mass, few.shape) * few.eigenvalue.asDiagonal();
    const double scale = multiply(model.stiffness, Eigen::MatrixXd(few.shape.cwiseAbs())).norm();
    EXPECT_LT(residual(model.free_dof, Eigen::all).norm(), 1e-9 * scale);
  }
}

TEST(Eigenmodes, FrequenciesDoNotDependOnTheFrame) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vector3d(0.3, 1.0, -2.0).normalized()).toRotationMatrix();
  std::vector<Vector3d> turned = testing::spline_points();
  for (Vector3d& point : turned) point = turn * point + Vector3d(5.0, -3.0, 1.0);
  const VectorXd f = frequencies(testing::spline_wire(), 20, 12);
  const VectorXd g = frequencies(testing::wire_along(spline_through(turned, 0.68)), 20, 12);
  EXPECT_LT(((f - g).array() / f.array()).abs().maxCoeff(), 1e-9);  // rounding, larger with the offset
}

TEST(Eigenmodes, AnSCurveWithStraightPiecesIsSmoothUnderRefinement) {
  // Collinear points at both ends and an inflection: where a Frenet frame fails.
  const Body body = testing::wire_along(spline_through({{0, 0, 0},
                                                        {0.1, 0, 0},
                                                        {0.2, 0, 0},
                                                        {0.35, 0.08, 0},
                                                        {0.5, 0.16, 0},
                                                        {0.6, 0.16, 0},
                                                        {0.7, 0.16, 0}}));
  const VectorXd a = frequencies(body, 20, 8);
  const VectorXd b = frequencies(body, 40, 8);
  const VectorXd c = frequencies(body, 80, 8);
  for (int r = 0; r < 8; ++r) {
    EXPECT_GT(a(r), b(r));
    EXPECT_GT(b(r), c(r));
    EXPECT_NEAR(std::log2((a(r) - b(r)) / (b(r) - c(r))), 4.0, 0.3);
  }
}

TEST(Eigenmodes, NaturalFrequencySolvesItsEquationForEveryLaw) {
  const double eigenvalue = 3e-4;
  const std::vector<FrequencyLaw> laws = {
      constant_law(120e9),
      {FrequencyLaw::Kind::power, {100e9, 0.1, 100.0}, {}, {}, 0.0, 0.0},
      {FrequencyLaw::Kind::power, {100e9, 1.8, 100.0}, {}, {}, 0.0, 0.0},
      {FrequencyLaw::Kind::power, {100e9, -1.0, 100.0}, {}, {}, 0.0, 0.0},
      {FrequencyLaw::Kind::fractional_zener, {90e9, 2.0, 500.0, 0.6}, {}, {}, 0.0, 0.0},
      {FrequencyLaw::Kind::table, {}, {100.0, 800.0, 1000.0}, {80e9, 100e9, 130e9}, 0.0, 0.0},
  };
  for (const FrequencyLaw& law : laws) {
    for (const double scale : {1e-3, 1.0, 1e3}) {
      const double f = natural_frequency_hz(scale * eigenvalue, law);
      const double omega = 2.0 * std::numbers::pi * f;
      EXPECT_NEAR(omega * omega / (law.at(f) * scale * eigenvalue), 1.0, 1e-13);
      EXPECT_NEAR(modulus_from_frequency(f, scale * eigenvalue) / law.at(f), 1.0, 1e-13);
    }
  }
  EXPECT_EQ(natural_frequency_hz(0.0, constant_law(1e11)), 0.0);
  EXPECT_EQ(natural_frequency_hz(-1e-12, constant_law(1e11)), 0.0);
  EXPECT_THROW(modulus_from_frequency(0.0, 1.0), Error);
  EXPECT_THROW(modulus_from_frequency(1.0, 0.0), Error);
}

TEST(Eigenmodes, RefusesAModelWithoutFreedom) {
  EXPECT_THROW(solve_eigenmodes(assemble(testing::straight_wire(), 1)), Error);
}

TEST(Eigenmodes, RigidModesAreToldByTheEnds) {
  using enum EndCondition;
  struct Case {
    EndCondition start, end;
    long rigid;
  };
  // A straight body between pins turns about its axis; pinned at one end only, also about that end.
  for (const auto& [start, end, rigid] :
       {Case{clamped, clamped, 0}, Case{clamped, free, 0}, Case{clamped, pinned, 0}, Case{pinned, pinned, 1},
        Case{pinned, free, 3}, Case{free, free, 6}}) {
    for (const int elements : {2, 30, 150}) {  // the last by the iterative solver
      Body body = testing::straight_wire();
      body.start = start;
      body.end = end;
      const VectorXd lambda = solve_eigenmodes(assemble(body, elements), 8).eigenvalue;
      EXPECT_EQ(rigid_modes(body, lambda), rigid) << elements;
      const VectorXd f = natural_frequencies_hz(body, lambda);
      EXPECT_EQ((f.array() == 0.0).count(), rigid);
      EXPECT_EQ(f(rigid), natural_frequency_hz(lambda(rigid), body.material.youngs_modulus));
    }
  }
}

}  // namespace
}  // namespace struna::fem
