#include "fem/harmonic.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/closed_forms.hpp"
#include "fem/error.hpp"
#include "fem/harmonic_problem.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::Vector3d;
using Eigen::VectorXd;

const std::vector<Vector3d> y_only = {Vector3d::UnitY()};
const std::vector<Vector3d> all_axes = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};

SupportMotion shake(End end, const Vector3d& direction = Vector3d::UnitY()) {
  return {{end}, direction};
}

ClampedBeam clamped_beam() {
  const Section section = solid_circle(0.0032);
  return {testing::wire_length, testing::wire_modulus * section.second_moment, 7650.0 * section.area};
}

VectorXd lines(std::initializer_list<double> f_hz) {
  VectorXd v(static_cast<long>(f_hz.size()));
  std::copy(f_hz.begin(), f_hz.end(), v.begin());
  return v;
}

double relative_error(Complex value, Complex exact) {
  return std::abs(value - exact) / std::abs(exact);
}

/// Meshes at which each of the reference's frequencies is below 1e-6. Finer ones are not better everywhere:
/// rounding grows as the fourth power of the elements and is largest, against the response, at the resonance
/// of the first mode.
struct Mesh {
  double f_hz;
  int elements;
};
const Mesh meshes[] = {{10, 28}, {24.4, 112}, {50, 80}, {100, 112}, {131.85, 280}, {500, 400}, {1000, 600}};

TEST(Harmonic, BothSupportForcesMeetTheClosedFormsToOneInAMillion) {
  for (const Mesh& mesh : meshes) {
    const Model model = assemble(testing::straight_wire(), mesh.elements);
    const VectorXd f = lines({mesh.f_hz});
    const Complex far =
        harmonic_response(model, shake(End::start), {SupportForce{End::end}, y_only}, f).response(0, 0);
    const Complex near =
        harmonic_response(model, shake(End::start), {SupportForce{End::start}, y_only}, f).response(0, 0);
    EXPECT_LT(relative_error(far, far_support_stiffness(clamped_beam(), 0.02, mesh.f_hz)), 1e-6) << mesh.f_hz;
    EXPECT_LT(relative_error(near, shaken_support_stiffness(clamped_beam(), 0.02, mesh.f_hz)), 1e-6)
        << mesh.f_hz;
  }
}

TEST(Harmonic, BothClampsShakenMeetTheClosedFormForStructuralAndRayleighDamping) {
  Body body = testing::straight_wire();
  body.material.rayleigh = {1.5, 5e-6};
  for (const Mesh& mesh : meshes) {
    const Model model = assemble(body, mesh.elements);
    const VectorXd f = lines({mesh.f_hz});
    const Drive drive = SupportMotion{{End::start, End::end}, Vector3d::UnitY()};
    const double omega = 2.0 * std::numbers::pi * mesh.f_hz;
    for (const Damping damping : {Damping::structural, Damping::viscous}) {
      const bool viscous = damping == Damping::viscous;
      const Complex stiffness = viscous ? Complex(1.0, 5e-6 * omega) : Complex(1.0, 0.02);
      const Complex mass = viscous ? Complex(1.0, -1.5 / omega) : Complex(1.0);
      Complex sum = 0.0;
      for (const End end : {End::start, End::end}) {
        sum +=
            harmonic_response(model, drive, {SupportForce{end}, y_only}, f, {damping, false}).response(0, 0);
      }
      EXPECT_LT(relative_error(sum, both_supports_stiffness(clamped_beam(), stiffness, mass, mesh.f_hz)),
                1e-6)
          << mesh.f_hz << " Hz, " << to_string(damping);
    }
  }
}

TEST(Harmonic, TransverseDirectionsAreAlike) {
  const Model model = assemble(testing::straight_wire(), 28);
  const VectorXd f = lines({10, 60, 300});
  const auto along = [&](const Vector3d& v) {
    return harmonic_response(model, shake(End::start, v), {SupportForce{End::end}, {v}}, f).response;
  };
  EXPECT_TRUE(along(Vector3d::UnitY()).isApprox(along(Vector3d::UnitZ()), 1e-10));
  EXPECT_TRUE(along(Vector3d::UnitY()).isApprox(along(Vector3d(0.0, 0.6, -0.8)), 1e-10));
}

TEST(Harmonic, AxialDriveMeetsTheRodsClosedForm) {
  // Fixed rod shaken at one end: force at the far clamp -E A k/sin(kL), k = w sqrt(rho/E).
  const Body body = testing::straight_wire();
  const double f_hz = 1000.0;
  const Complex modulus = 120e9 * Complex(1.0, 0.02);
  const Complex k = 2.0 * std::numbers::pi * f_hz * std::sqrt(body.density / modulus);
  const Complex exact = -modulus * body.section.area * k / std::sin(k * testing::wire_length);
  const Model model = assemble(body, 60);
  const Complex value = harmonic_response(model, shake(End::start, Vector3d::UnitX()),
                                          {SupportForce{End::end}, {Vector3d::UnitX()}}, lines({f_hz}))
                            .response(0, 0);
  EXPECT_LT(relative_error(value, exact), 3e-5);  // linear rod elements: (kh)^2/24 per element
}

TEST(Harmonic, MeshErrorEstimateTellsTheActualError) {
  const VectorXd f = lines({10, 24.4, 50, 100, 131.85, 500, 1000});
  for (const int elements : {14, 28, 56}) {
    const HarmonicResponse r =
        harmonic_response(assemble(testing::straight_wire(), elements), shake(End::start),
                          {SupportForce{End::end}, y_only}, f, {Damping::structural, true});
    for (long line = 0; line < f.size(); ++line) {
      const double actual =
          std::abs(r.response(line, 0) - far_support_stiffness(clamped_beam(), 0.02, f(line)));
      // Within a tenth where the error is small against the response and clear of rounding; within a factor
      // of two where 14 elements are far too few (a third of the response at 1 kHz).
      const double factor = actual < 0.05 * std::abs(r.response(line, 0)) ? 1.1 : 2.0;
      EXPECT_LT(r.mesh_error(line, 0), factor * actual) << elements << ", " << f(line);
      EXPECT_GT(r.mesh_error(line, 0), actual / factor) << elements << ", " << f(line);
    }
  }
}

TEST(Harmonic, MeshErrorIsLeftOutUnlessAskedFor) {
  const HarmonicResponse r = harmonic_response(assemble(testing::straight_wire(), 8), shake(End::start),
                                               {SupportForce{End::end}, y_only}, lines({10.0}));
  EXPECT_EQ(r.mesh_error.size(), 0);
}

TEST(Harmonic, StaticLimitIsTheStiffnessEntry) {
  const double spring = 23.5724957423;
  const Model model = assemble(testing::straight_wire(), 12);
  const VectorXd f = lines({0.01});
  const Complex near =
      harmonic_response(model, shake(End::start), {SupportForce{End::start}, y_only}, f).response(0, 0);
  const Complex far =
      harmonic_response(model, shake(End::start), {SupportForce{End::end}, y_only}, f).response(0, 0);
  // The support's force on the structure: positive at the shaken end. (f/f1)^2 remains.
  EXPECT_LT(relative_error(near, spring * Complex(1.0, 0.02)), 1e-5);
  EXPECT_LT(relative_error(far, -spring * Complex(1.0, 0.02)), 1e-5);
}

TEST(Harmonic, ReciprocityHoldsOnACurve) {
  const Model model = assemble(testing::spline_wire(), 16);
  const VectorXd f = lines({12.0, 61.0, 333.0});
  const Vector3d a = Vector3d(1.0, 2.0, -1.0).normalized();
  const Vector3d b = Vector3d(-0.3, 1.0, 0.5).normalized();
  // Force/motion between the supports.
  const MatrixXcd ab =
      harmonic_response(model, shake(End::start, a), {SupportForce{End::end}, {b}}, f).response;
  const MatrixXcd ba =
      harmonic_response(model, shake(End::end, b), {SupportForce{End::start}, {a}}, f).response;
  EXPECT_TRUE(ab.isApprox(ba, 1e-9));  // rounding
  // Displacement/force between points inside elements.
  const MatrixXcd pq =
      harmonic_response(model, PointForce{0.31, a}, {PointDisplacement{0.77}, {b}}, f).response;
  const MatrixXcd qp =
      harmonic_response(model, PointForce{0.77, b}, {PointDisplacement{0.31}, {a}}, f).response;
  EXPECT_TRUE(pq.isApprox(qp, 1e-9));
  // Displacement/motion against force/force: opposite signs by Betti's theorem.
  const MatrixXcd transmitted =
      harmonic_response(model, shake(End::start, a), {PointDisplacement{0.77}, {b}}, f).response;
  const MatrixXcd reaction =
      harmonic_response(model, PointForce{0.77, b}, {SupportForce{End::start}, {a}}, f).response;
  EXPECT_TRUE(transmitted.isApprox(-reaction, 1e-9));
}

TEST(Harmonic, SupportForcesBalanceTheInertia) {
  // Sum of both support forces = -w^2 (1 - i alpha/w) times the body's momentum per motion, from the
  // displacement field.
  Body body = testing::spline_wire();
  body.material.rayleigh = {20.0, 1e-6};
  const int elements = 20;
  const Model model = assemble(body, elements);
  const VectorXd f = lines({40.0, 222.0});
  const Drive drive = shake(End::start);
  for (const Damping damping : {Damping::structural, Damping::viscous}) {
    MatrixXcd forces = MatrixXcd::Zero(2, 3);
    for (const End end : {End::start, End::end}) {
      forces += harmonic_response(model, drive, {SupportForce{end}, all_axes}, f, {damping, false}).response;
    }
    // All nodal dof of the solution follow from reciprocity-free probes: displacements at nodes only carry
    // part of the momentum, so integrate finely inside the elements.
    const int stations = 40 * elements;
    MatrixXcd momentum = MatrixXcd::Zero(2, 3);
    for (int i = 0; i < stations; ++i) {
      momentum += harmonic_response(model, drive, {PointDisplacement{(i + 0.5) / stations}, all_axes}, f,
                                    {damping, false})
                      .response /
                  stations;
    }
    const double mass = body.density * body.section.area * body.centreline.length();
    for (long line = 0; line < 2; ++line) {
      const double omega = 2.0 * std::numbers::pi * f(line);
      const Complex inertia =
          -omega * omega * (damping == Damping::viscous ? Complex(1.0, -20.0 / omega) : Complex(1.0));
      const double scale = forces.row(line).norm();
      // The midpoint rule's error, (1/40)^2/24 of an element's curvature of motion.
      EXPECT_LT((forces.row(line) - inertia * mass * momentum.row(line)).norm(), 2e-4 * scale);
    }
  }
}

TEST(Harmonic, AForceAtASupportGoesStraightIntoIt) {
  const Model model = assemble(testing::straight_wire(), 8);
  const MatrixXcd at_end = harmonic_response(model, PointForce{1.0, Vector3d::UnitY()},
                                             {SupportForce{End::end}, y_only}, lines({30.0}))
                               .response;
  EXPECT_LT(std::abs(at_end(0, 0) + 1.0), 1e-12);
}

TEST(Harmonic, ShakingTheWholeFrameStaticallyMovesEveryPointAlong) {
  const Model model = assemble(testing::spline_wire(), 12);
  const MatrixXcd moved = harmonic_response(model, SupportMotion{{End::start, End::end}, Vector3d::UnitY()},
                                            {PointDisplacement{0.37}, all_axes}, lines({1e-3}))
                              .response;
  EXPECT_LT((moved.transpose() - Eigen::Vector3cd(0.0, 1.0, 0.0)).norm(), 1e-6);  // (f/f1)^2 and rounding
}

TEST(Harmonic, MaterialLawsAreReadAtEachLine) {
  Body body = testing::straight_wire();
  const VectorXd f = lines({40.0, 80.0, 160.0, 320.0, 640.0});
  body.material.youngs_modulus = {FrequencyLaw::Kind::power, {100e9, 0.2, 100.0}, {}, {}, 0.0, 0.0};
  body.material.loss_factor = {FrequencyLaw::Kind::table, {}, {10.0, 1000.0}, {0.01, 0.05}, 0.0, 0.0};
  const MatrixXcd swept =
      harmonic_response(assemble(body, 12), shake(End::start), {SupportForce{End::end}, y_only}, f).response;
  for (long line = 0; line < f.size(); ++line) {
    Body frozen = body;
    frozen.material.youngs_modulus = constant_law(body.material.youngs_modulus.at(f(line)));
    frozen.material.loss_factor = constant_law(body.material.loss_factor.at(f(line)));
    const MatrixXcd one = harmonic_response(assemble(frozen, 12), shake(End::start),
                                            {SupportForce{End::end}, y_only}, lines({f(line)}))
                              .response;
    EXPECT_LT(relative_error(swept(line, 0), one(0, 0)), 1e-12);
  }
}

/// Residue at a mode from the response itself: H at four points around the pole's frequency minus what varies
/// slowly, by a fit of H = C (1 + i eta)/(w_r^2 (1 + i eta) - w^2) + a + b w^2.
double fitted_constant(const VectorXd& f, const Eigen::VectorXcd& h, double f_r, double eta) {
  const double w_r = 2.0 * std::numbers::pi * f_r;
  MatrixXcd basis(f.size(), 3);
  for (long i = 0; i < f.size(); ++i) {
    const double w = 2.0 * std::numbers::pi * f(i);
    basis.row(i) << Complex(1.0, eta) / (w_r * w_r * Complex(1.0, eta) - w * w), 1.0,
        (w * w) / (w_r * w_r) - 1.0;
  }
  const MatrixXcd normal = basis.adjoint() * basis;
  const Eigen::VectorXcd right = basis.adjoint() * h;
  return Eigen::VectorXcd(normal.inverse() * right)(0).real();
}

TEST(Harmonic, ModalConstantsAreTheResiduesOfTheResponseSignIncluded) {
  Body body = testing::spline_wire();
  const double eta = 1e-5;
  body.material.loss_factor = constant_law(eta);
  const Model model = assemble(body, 16);
  const Eigenmodes modes = solve_eigenmodes(model, 6);
  const Vector3d direction = Vector3d(0.2, 1.0, 0.4).normalized();
  struct Case {
    Drive drive;
    Measurement measurement;
    bool per_acceleration;
  };
  const std::vector<Case> cases = {
      {shake(End::start, direction), {SupportForce{End::end}, all_axes}, true},
      {shake(End::start, direction), {SupportForce{End::start}, all_axes}, true},
      {PointForce{0.4, direction}, {PointDisplacement{0.63}, all_axes}, false},
      {shake(End::start, direction), {PointDisplacement{0.63}, all_axes}, false},
      {PointForce{0.4, direction}, {SupportForce{End::end}, all_axes}, false},
  };
  for (const Case& c : cases) {
    const Eigen::MatrixXd constants =
        modal_constants(model, modes, c.drive, c.measurement, body.material.youngs_modulus);
    const double scale = constants.cwiseAbs().maxCoeff();
    for (int r = 0; r < 6; ++r) {
      const double f_r = natural_frequency_hz(modes.eigenvalue(r), body.material.youngs_modulus);
      const VectorXd f = f_r * (VectorXd::LinSpaced(9, -4.0, 4.0).array() * eta + 1.0);
      const MatrixXcd response = harmonic_response(model, c.drive, c.measurement, f).response;
      for (int k = 0; k < 3; ++k) {
        Eigen::VectorXcd h = response.col(k);
        if (c.per_acceleration) h.array() /= -(2.0 * std::numbers::pi * f.array()).square().cast<Complex>();
        EXPECT_NEAR(fitted_constant(f, h, f_r, eta), constants(r, k), 2e-5 * scale)
            << "mode " << r << " output " << k;
      }
    }
  }
}

TEST(Harmonic, ModalSumInApparentMassFormApproachesTheDirectResponse) {
  // -w^2-form: momentum sum over all modes plus the constant part, by comparing two frequencies' difference.
  Body body = testing::straight_wire();
  const Model model = assemble(body, 10);
  const Eigenmodes modes = solve_eigenmodes(model);
  const Drive drive = shake(End::start);
  const Measurement far = {SupportForce{End::end}, y_only};
  const Eigen::MatrixXd constants = modal_constants(model, modes, drive, far, body.material.youngs_modulus);
  const VectorXd f = lines({40.0, 300.0});
  const MatrixXcd direct = harmonic_response(model, drive, far, f).response;
  Eigen::Vector2cd apparent;
  Eigen::Vector2cd sum = Eigen::Vector2cd::Zero();
  Eigen::Vector2cd rest;  // static share: K's direct term over -w^2, the same residual for both
  for (int line = 0; line < 2; ++line) {
    const double w2 = std::pow(2.0 * std::numbers::pi * f(line), 2);
    apparent(line) = direct(line, 0) / -w2;
    for (long r = 0; r < modes.eigenvalue.size(); ++r) {
      const Complex pole = 120e9 * modes.eigenvalue(r) * Complex(1.0, 0.02);
      sum(line) += constants(r, 0) * Complex(1.0, 0.02) / (pole - w2);
    }
    rest(line) = apparent(line) - sum(line);
  }
  // What is left is a constant mass plus a spring over -w^2; the spring is the static one, -12 E I/L^3.
  const double spring = -12.0 * clamped_beam().bending_stiffness / std::pow(testing::wire_length, 3);
  const auto static_share = [&](int line) {
    return spring * Complex(1.0, 0.02) / -std::pow(2.0 * std::numbers::pi * f(line), 2);
  };
  const Complex left = (rest(0) - static_share(0)) - (rest(1) - static_share(1));
  EXPECT_LT(std::abs(left), 1e-7 * std::abs(apparent(1)));
}

TEST(Harmonic, OnlyWhatTheDriveReachesIsSolved) {
  constexpr int elements = 10, free_nodes = elements - 1;
  const Measurement far{SupportForce{End::end}, all_axes};
  const auto per_node = [&](const Body& body, const Drive& drive) {
    const HarmonicProblem problem(assemble(body, elements), drive, far);
    EXPECT_EQ(problem.dof.size() % free_nodes, 0u);
    return problem.dof.size() / free_nodes;
  };
  const Vector3d tilted(0.0, 0.6, 0.8);
  const Body straight = testing::straight_wire();
  EXPECT_EQ(per_node(straight, shake(End::start)), 2u);
  EXPECT_EQ(per_node(straight, PointForce{0.25, Vector3d::UnitZ()}), 2u);
  EXPECT_EQ(per_node(straight, shake(End::start, Vector3d::UnitX())), 1u);
  EXPECT_EQ(per_node(straight, shake(End::start, tilted)), 4u);
  const Body arc = testing::arc_wire(60.0);  // in the plane of x and y
  EXPECT_EQ(per_node(arc, shake(End::start)), 3u);
  EXPECT_EQ(per_node(arc, shake(End::start, Vector3d::UnitZ())), 3u);
  EXPECT_EQ(per_node(testing::spline_wire(), shake(End::start)), 6u);
  // Along no axis: directions carry rounding, and the plane is still found.
  const Body turned =
      testing::wire_along(straight_line({0.0, 0.0, 0.0}, {0.48, 0.48 * std::cos(1.5707963267948966), 0.0}));
  EXPECT_EQ(per_node(turned, shake(End::start)), 2u);
}

TEST(Harmonic, WhatTheDriveDoesNotReachAddsNothing) {
  // A sag of 1e-9 m joins everything to everything and changes nothing else.
  const VectorXd f = lines({20.0, 130.0, 700.0});
  const Body bent = testing::wire_along(
      spline_through({{0.0, 0.0, 0.0}, {0.3, 3e-10, 1e-9}, {testing::wire_length, 0.0, 0.0}}));
  const Drive drive = shake(End::start);
  const Measurement far{SupportForce{End::end}, y_only};
  const Model model = assemble(bent, 24);
  ASSERT_EQ(HarmonicProblem(model, drive, far).dof.size(), model.free_dof.size());
  const MatrixXcd whole = harmonic_response(model, drive, far, f).response;
  const MatrixXcd part = harmonic_response(assemble(testing::straight_wire(), 24), drive, far, f).response;
  for (long i = 0; i < f.size(); ++i) EXPECT_LT(relative_error(part(i, 0), whole(i, 0)), 1e-8) << f(i);
}

TEST(Harmonic, ManyLinesAreTheLinesOneByOne) {
  // Many lines are summed over all modes, a line alone is a factorisation.
  const Drive drives[] = {shake(End::start), SupportMotion{{End::start, End::end}, Vector3d(0.6, 0.0, 0.8)},
                          PointForce{0.3, Vector3d::UnitZ()}};
  const VectorXd f = VectorXd::LinSpaced(60, 2.0, 900.0);
  const std::pair<EndCondition, EndCondition> ends[] = {{EndCondition::clamped, EndCondition::clamped},
                                                        {EndCondition::pinned, EndCondition::pinned},
                                                        {EndCondition::pinned, EndCondition::free}};
  for (const auto& [start, end] : ends) {
    Body body = testing::spline_wire();
    body.start = start;
    body.end = end;
    body.material.rayleigh = {1.5, 5e-6};
    const Model model = assemble(body, 10);
    std::vector<Measurement> measurements = {{SupportForce{End::start}, all_axes},
                                             {PointDisplacement{0.7}, all_axes}};
    if (end != EndCondition::free) measurements.push_back({SupportForce{End::end}, all_axes});
    for (std::size_t d = 0; d < std::size(drives); ++d) {
      if (d == 1 && end == EndCondition::free) continue;
      for (const Measurement& measurement : measurements) {
        for (const Damping damping : {Damping::structural, Damping::viscous}) {
          const MatrixXcd many = harmonic_response(model, drives[d], measurement, f, {damping}).response;
          for (const long i : {0L, 7L, 31L, 59L}) {
            // Rounding of the factorisation: at 2 Hz the inertia of a body moved as a whole is 1e-10 of its
            // stiffness.
            const double tolerance = i == 0 ? 1e-8 : 2e-10;
            const MatrixXcd one =
                harmonic_response(model, drives[d], measurement, lines({f(i)}), {damping}).response;
            EXPECT_LT((many.row(i) - one).norm(), tolerance * one.norm()) << f(i) << " Hz, drive " << d;
          }
        }
      }
    }
  }
}

TEST(Harmonic, UndampedLinesBetweenResonancesAreRealAndExact) {
  Body body = testing::straight_wire();
  body.material.loss_factor = constant_law(0.0);
  const HarmonicResponse r =
      harmonic_response(assemble(body, 56), shake(End::start), {SupportForce{End::end}, y_only},
                        lines({10.0, 50.0, 100.0, 180.0}));
  for (long line = 0; line < 4; ++line) {
    EXPECT_EQ(r.response(line, 0).imag(), 0.0);
    EXPECT_LT(
        relative_error(r.response(line, 0), far_support_stiffness(clamped_beam(), 0.0, r.frequency_hz(line))),
        1e-5);
  }
}

TEST(Harmonic, RefusesWhatCannotBeDrivenOrMeasured) {
  Body body = testing::straight_wire();
  const Model clamped = assemble(body, 6);
  body.end = EndCondition::free;
  const Model cantilever = assemble(body, 6);
  const Measurement far = {SupportForce{End::end}, y_only};
  const Drive start = shake(End::start);
  const VectorXd f = lines({20.0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(harmonic_response(cantilever, start, far, f), Error);  // free end
  EXPECT_THROW(harmonic_response(cantilever, shake(End::end), {SupportForce{End::start}, y_only}, f), Error);
  EXPECT_THROW(harmonic_response(clamped, start, far, lines({0.0})), Error);
  EXPECT_THROW(harmonic_response(clamped, start, far, lines({-5.0})), Error);
  EXPECT_THROW(harmonic_response(clamped, start, far, lines({nan})), Error);
  EXPECT_THROW(harmonic_response(clamped, shake(End::start, {0.0, 2.0, 0.0}), far, f),
               Error);  // not a unit vector
  EXPECT_THROW(harmonic_response(clamped, shake(End::start, {nan, 0.0, 0.0}), far, f), Error);
  EXPECT_THROW(harmonic_response(clamped, SupportMotion{{}, Vector3d::UnitY()}, far, f), Error);
  EXPECT_THROW(harmonic_response(clamped, start, {SupportForce{End::end}, {}}, f), Error);
  EXPECT_THROW(harmonic_response(clamped, start, {SupportForce{End::end}, {Vector3d(1.0, 1.0, 0.0)}}, f),
               Error);
  EXPECT_THROW(harmonic_response(clamped, PointForce{1.2, Vector3d::UnitY()}, far, f), Error);
  EXPECT_THROW(harmonic_response(clamped, start, {PointDisplacement{-0.1}, y_only}, f), Error);
  EXPECT_THROW(harmonic_response(assemble(testing::straight_wire(), 1), start, far, f),
               Error);  // no free dof
  EXPECT_NO_THROW(harmonic_response(cantilever, start, {SupportForce{End::start}, y_only}, f));
}

// Rows of several references are those of each drive by itself, and the modal constants are theirs too.
TEST(Harmonic, ReferencesAreTheDrivesOneByOne) {
  const Model model = assemble(testing::spline_wire(), 12);
  const Vector3d y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  Measurement both = {SupportForce{End::end}, {y, z, z, y}};
  both.drive_directions = {y, y, z, z};
  const VectorXd f = lines({20.0, 55.0, 130.0});
  const HarmonicResponse all =
      harmonic_response(model, shake(End::start), both, f, {Damping::structural, true});
  const Eigenmodes modes = solve_eigenmodes(model, 4);
  const Eigen::MatrixXd constants =
      modal_constants(model, modes, shake(End::start), both, constant_law(1e11));
  for (const auto& [direction, first] : {std::pair(y, 0L), std::pair(z, 2L)}) {
    const Measurement one = {SupportForce{End::end},
                             {both.directions[static_cast<std::size_t>(first)],
                              both.directions[static_cast<std::size_t>(first + 1)]}};
    const Drive drive = shake(End::start, direction);
    const HarmonicResponse alone = harmonic_response(model, drive, one, f, {Damping::structural, true});
    EXPECT_EQ(alone.response, all.response.middleCols(first, 2));
    EXPECT_EQ(alone.mesh_error, all.mesh_error.middleCols(first, 2));
    EXPECT_EQ(modal_constants(model, modes, drive, one, constant_law(1e11)), constants.middleCols(first, 2));
  }
  both.drive_directions.pop_back();
  EXPECT_THROW(harmonic_response(model, shake(End::start), both, f), Error);
}

}  // namespace
}  // namespace struna::fem
