#include "fem/beam_element.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/model.hpp"
#include "fem/quadrature.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using Vector12 = Eigen::Matrix<double, 12, 1>;

double relative_difference(const Matrix12& a, const Matrix12& b) {
  return (a - b).norm() / b.norm();
}

/// Rigid motion (u at the origin, theta) of the two end points.
Vector12 rigid_motion(const Vector3d& a, const Vector3d& b, const Vector3d& shift, const Vector3d& turn) {
  Vector12 q;
  q.segment<3>(0) = shift + turn.cross(a);
  q.segment<3>(3) = turn;
  q.segment<3>(6) = shift + turn.cross(b);
  q.segment<3>(9) = turn;
  return q;
}

/// Every curve that the tests go through: straight, arcs, and a piece of a spline with an inflection.
std::vector<Body> curved_bodies() {
  return {testing::arc_wire(60.0), testing::arc_wire(180.0), testing::spline_wire(),
          testing::wire_along(spline_through({{0, 0, 0}, {0.2, 0.1, 0}, {0.4, -0.1, 0}, {0.6, 0, 0}}, 0.68))};
}

TEST(BeamElement, IsTheHermiteElementOnAStraightLine) {
  const Vector3d tangent = Vector3d(1.0, 2.0, -0.5).normalized();
  const Body body =
      testing::wire_along(straight_line({0.1, 0.0, 0.2}, Vector3d(0.1, 0.0, 0.2) + 0.68 * tangent));
  const ElementMatrices general = beam_element(body, 0.2, 0.25);
  const ElementMatrices hermite = straight_beam_element(body, 0.05, tangent);
  EXPECT_LT(relative_difference(general.stiffness, hermite.stiffness), 1e-13);  // rounding
  // Rounding times the ratio of axial to bending stiffness, A h^2/(12 I) = 325.
  EXPECT_LT(relative_difference(general.mass, hermite.mass), 2e-12);
}

TEST(BeamElement, StraightElementHasTheTextbookEntries) {
  const Body body = testing::straight_wire();
  const double h = 0.1;
  const ElementMatrices e = straight_beam_element(body, h, Vector3d::UnitX());
  const double i = body.section.second_moment;
  const double m = body.density * body.section.area * h;
  EXPECT_DOUBLE_EQ(e.stiffness(0, 6), -body.section.area / h);
  EXPECT_DOUBLE_EQ(e.stiffness(1, 1), 12.0 * i / (h * h * h));
  EXPECT_DOUBLE_EQ(e.stiffness(1, 5), 6.0 * i / (h * h));   // v with rotation about z
  EXPECT_DOUBLE_EQ(e.stiffness(2, 4), -6.0 * i / (h * h));  // w with rotation about y
  EXPECT_DOUBLE_EQ(e.stiffness(5, 11), 2.0 * i / h);
  EXPECT_DOUBLE_EQ(e.stiffness(3, 3), body.section.torsion_constant / (2.6 * h));
  EXPECT_DOUBLE_EQ(e.mass(1, 1), 156.0 / 420.0 * m);
  EXPECT_DOUBLE_EQ(e.mass(1, 11), -13.0 / 420.0 * m * h);
  EXPECT_DOUBLE_EQ(e.mass(0, 6), m / 6.0);
  EXPECT_DOUBLE_EQ(e.mass(3, 3), body.density * 2.0 * i * h / 3.0);
}

/// Flexibility of the free end of a quarter ring held at the other, by Castigliano with bending, torsion and
/// stretch.
void expect_quarter_ring(const Body& body, double radius, const Eigen::Matrix<double, 6, 6>& flexibility,
                         double tolerance) {
  const double bend = std::pow(radius, 3) / body.section.second_moment;
  const double twist = 2.0 * (1.0 + body.poisson) * std::pow(radius, 3) / body.section.torsion_constant;
  const double stretch = radius / body.section.area;
  const double quarter = 0.25 * std::numbers::pi;
  EXPECT_NEAR(flexibility(0, 0), quarter * (bend + stretch), tolerance * bend);
  EXPECT_NEAR(flexibility(1, 1), (3.0 * quarter - 2.0) * bend + quarter * stretch, tolerance * bend);
  EXPECT_NEAR(flexibility(0, 1), 0.5 * (stretch - bend), tolerance * bend);
  EXPECT_NEAR(flexibility(2, 2), quarter * bend + (3.0 * quarter - 2.0) * twist, tolerance * bend);
}

TEST(BeamElement, EndFlexibilityOfAQuarterRingMeetsCastigliano) {
  const double radius = 0.3;
  Body body = testing::wire_along(circular_arc(0.5 * std::numbers::pi * radius, 0.5 * std::numbers::pi));
  const Matrix12 k = beam_element(body, 0.0, body.centreline.length()).stiffness;
  // Remainder of four Gauss points for sin^2 over 90 degrees: (pi/2)^9 4!^4/(9 8!^3) 2^7 = 4e-6.
  expect_quarter_ring(body, radius, k.bottomRightCorner<6, 6>().inverse(), 5e-6);
  // Six elements of 15 degrees: the remainder is gone, rounding is left.
  body.end = EndCondition::free;
  const Model model = assemble(body, 6);
  const Eigen::MatrixXd inverse = submatrix(model.stiffness, model.free_dof).dense().inverse();
  expect_quarter_ring(body, radius, inverse.bottomRightCorner<6, 6>(), 1e-9);
}

TEST(BeamElement, MatricesAreSymmetricAndDefinite) {
  for (const Body& body : curved_bodies()) {
    const ElementMatrices e = beam_element(body, 0.21, 0.25);
    EXPECT_LT((e.stiffness - e.stiffness.transpose()).norm(), 1e-15 * e.stiffness.norm());
    EXPECT_LT((e.mass - e.mass.transpose()).norm(), 1e-15 * e.mass.norm());
    const Eigen::SelfAdjointEigenSolver<Matrix12> mass(e.mass);
    EXPECT_GT(mass.eigenvalues()(0), 0.0);
    const Eigen::SelfAdjointEigenSolver<Matrix12> stiffness(e.stiffness);
    EXPECT_GT(stiffness.eigenvalues()(6), 0.0);
  }
}

TEST(BeamElement, EachLaneHoldsItsElementAndThoseBeyondTheLastRepeatIt) {
  const std::vector<double> arc_length = {0.0, 0.1, 0.13, 0.2, 0.24, 0.31, 0.4};
  for (const Body& body : curved_bodies()) {
    std::vector<Vector3d> node;
    for (const double s : arc_length) node.push_back(body.centreline.at(s).position);
    for (const int first : {0, 4}) {
      const LaneElementMatrices lanes = beam_elements(body, arc_length, node, first);
      for (int lane = 0; lane < Lane::count; ++lane) {
        const auto element = static_cast<std::size_t>(std::min(first + lane, 5));
        const ElementMatrices one = beam_element(body, arc_length[element], arc_length[element + 1]);
        for (int j = 0; j < 12; ++j) {
          for (int i = j; i < 12; ++i) {
            // The same instructions on the same numbers.
            EXPECT_EQ(lanes.stiffness(i, j)[lane], one.stiffness(i, j));
            EXPECT_EQ(lanes.mass(i, j)[lane], one.mass(i, j));
          }
        }
      }
    }
  }
}

TEST(BeamElement, RigidMotionsCostNoEnergyOnACurve) {
  for (const Body& body : curved_bodies()) {
    const double s0 = 0.2;
    const double s1 = 0.26;
    const Matrix12 k = beam_element(body, s0, s1).stiffness;
    const Vector3d a = body.centreline.at(s0).position;
    const Vector3d b = body.centreline.at(s1).position;
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT((k * rigid_motion(a, b, Vector3d::Unit(i), Vector3d::Zero())).norm(), 1e-14 * k.norm());
      EXPECT_LT((k * rigid_motion(a, b, Vector3d::Zero(), Vector3d::Unit(i))).norm(), 1e-14 * k.norm());
    }
  }
}

TEST(BeamElement, RigidTranslationCarriesTheElementsMass) {
  for (const Body& body : curved_bodies()) {
    const Matrix12 mass = beam_element(body, 0.2, 0.26).mass;
    for (int i = 0; i < 3; ++i) {
      const Vector12 q = rigid_motion({0, 0, 0}, {0, 0, 0}, Vector3d::Unit(i), Vector3d::Zero());
      EXPECT_NEAR(q.dot(mass * q) / (body.density * body.section.area * 0.06), 1.0, 1e-13);  // rounding
    }
  }
}

TEST(BeamElement, RigidRotationCarriesTheMomentOfInertiaOfTheCurve) {
  const std::vector<Body> bodies = curved_bodies();
  for (std::size_t body_index = 0; body_index < bodies.size(); ++body_index) {
    const Body& body = bodies[body_index];
    const double s0 = 0.2;
    const double s1 = 0.26;
    const ElementMatrices e = beam_element(body, s0, s1);
    const GaussRule rule = gauss_legendre(12);
    for (int axis = 0; axis < 3; ++axis) {
      double inertia = 0.0;
      for (int g = 0; g < rule.node.size(); ++g) {
        const CurvePoint at = body.centreline.at(s0 + (s1 - s0) * rule.node(g));
        const double twist = at.tangent(axis);
        inertia += (s1 - s0) * rule.weight(g) * body.density *
                   (body.section.area * Vector3d::Unit(axis).cross(at.position).squaredNorm() +
                    2.0 * body.section.second_moment * twist * twist);
      }
      const Vector12 q = rigid_motion(body.centreline.at(s0).position, body.centreline.at(s1).position,
                                      Vector3d::Zero(), Vector3d::Unit(axis));
      // Gauss quadrature: all but exact on the arcs; on the splines a knot, where r''' jumps, lies in the
      // element.
      EXPECT_NEAR(q.dot(e.mass * q) / inertia, 1.0, body_index < 2 ? 1e-11 : 2e-5)
          << body_index << ", axis " << axis;
    }
  }
}

TEST(BeamElement, TurnsWithItsCurve) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  std::vector<Vector3d> turned = testing::spline_points();
  for (Vector3d& point : turned) point = turn * point;
  const ElementMatrices e =
      beam_element(testing::wire_along(spline_through(testing::spline_points(), 0.68)), 0.2, 0.25);
  const ElementMatrices r = beam_element(testing::wire_along(spline_through(turned, 0.68)), 0.2, 0.25);
  Matrix12 rotation = Matrix12::Zero();
  for (int i = 0; i < 4; ++i) rotation.block<3, 3>(3 * i, 3 * i) = turn;
  // Rounding of the turned points, times the ratio of axial to bending stiffness, some 300.
  EXPECT_LT(relative_difference(r.stiffness, rotation * e.stiffness * rotation.transpose()), 1e-12);
  EXPECT_LT(relative_difference(r.mass, rotation * e.mass * rotation.transpose()), 1e-12);
}

TEST(BeamElement, ShapeFunctionsInterpolateTheEndsAndCarryRigidMotion) {
  for (const Body& body : curved_bodies()) {
    const double s0 = 0.2;
    const double s1 = 0.26;
    const Vector3d a = body.centreline.at(s0).position;
    const Vector3d b = body.centreline.at(s1).position;
    Matrix3x12 at_start = Matrix3x12::Zero();
    at_start.leftCols<3>().setIdentity();
    // Rounding times the ratio of axial to bending flexibility, some 300: the shapes come from solving with
    // the element's flexibility. At the end they are sums of integrals over the whole element.
    EXPECT_LT((beam_displacement(body, s0, s1, s0) - at_start).norm(), 1e-12);
    Matrix3x12 at_end = Matrix3x12::Zero();
    at_end.middleCols<3>(6).setIdentity();
    EXPECT_LT((beam_displacement(body, s0, s1, s1) - at_end).norm(), 1e-11);
    const double s = 0.237;
    const Vector3d shift(0.3, -0.2, 0.1);
    const Vector3d turn(-0.4, 0.9, 0.2);
    const Vector3d moved = beam_displacement(body, s0, s1, s) * rigid_motion(a, b, shift, turn);
    // Rounding: a rigid motion strains nothing, so that no stiffness enters.
    EXPECT_LT((moved - shift - turn.cross(body.centreline.at(s).position)).norm(), 1e-13);
  }
}

TEST(BeamElement, ShapeFunctionsOfAStraightElementAreHermites) {
  const Body body = testing::straight_wire();
  const double h = 0.08;
  const Matrix3x12 shape = beam_displacement(body, 0.1, 0.1 + h, 0.1 + 0.3 * h);
  const double x = 0.3;
  EXPECT_NEAR(shape(0, 0), 1.0 - x, 1e-14);
  EXPECT_NEAR(shape(1, 1), 1.0 - 3.0 * x * x + 2.0 * x * x * x, 1e-14);
  EXPECT_NEAR(shape(1, 5), h * (x - 2.0 * x * x + x * x * x), 1e-15);
  EXPECT_NEAR(shape(2, 4), -h * (x - 2.0 * x * x + x * x * x), 1e-15);
  EXPECT_NEAR(shape(1, 11), h * (x * x * x - x * x), 1e-15);
}

}  // namespace
}  // namespace struna::fem
