#include "fem/contact_geometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "bodies.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

using testing::spline_points;
using testing::straight_wire;
using testing::wire_along;

Model meshed(const Centreline& curve, int elements, EndCondition ends = EndCondition::clamped) {
  Body body = wire_along(curve);
  body.start = body.end = ends;
  return assemble(body, elements);
}

TEST(ContactGeometry, SameCurveWithOtherMeshIsConcentricToRounding) {
  const Centreline curve = spline_through(spline_points(), 0.68);
  const Model wire = meshed(curve, 29);
  const Model band = meshed(curve, 17);
  const std::vector<ContactPair> pairs = contact_pairs(wire, band);
  ASSERT_EQ(pairs.size(), 28u);  // both clamped ends are left out
  for (const ContactPair& pair : pairs) {
    // A few roundings of coordinates of size 1 m.
    EXPECT_LT(pair.rest_offset.norm(), 5e-15) << pair.node;
    EXPECT_NEAR(pair.outside_arc_length, pair.inside_arc_length, 5e-14);
  }
}

TEST(ContactGeometry, EccentricStraightBodiesKnowTheirOffset) {
  const Model wire = meshed(straight_line({0, 0, 0}, {0.6, 0, 0}), 12);
  const Model band = meshed(straight_line({0, 2e-4, -3e-4}, {0.6, 2e-4, -3e-4}), 7);
  const std::vector<ContactPair> pairs = contact_pairs(wire, band);
  ASSERT_EQ(pairs.size(), 11u);
  for (const ContactPair& pair : pairs) {
    const Eigen::Vector3d offset = pair.plane_axes * pair.rest_offset;
    EXPECT_NEAR((offset - Eigen::Vector3d(0, -2e-4, 3e-4)).norm(), 0.0, 1e-15);  // rounding
  }
}

TEST(ContactGeometry, ConcentricArcsOfOtherRadiusAreTheDifferenceApart) {
  // Wire: radius R, quarter circle. Band: the same centre, radius R + 1 mm, in the plane of the first.
  const double radius = 0.4;
  const Model wire = meshed(circular_arc(radius * std::numbers::pi / 2, std::numbers::pi / 2), 10);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= 400; ++i) {
    const double angle = std::numbers::pi / 2 * i / 400;
    points.push_back({(radius + 1e-3) * std::sin(angle), radius - (radius + 1e-3) * std::cos(angle), 0.0});
  }
  const std::vector<ContactPair> pairs = contact_pairs(wire, meshed(spline_through(points), 13));
  for (const ContactPair& pair : pairs) {
    if (pair.node < 2 || pair.node > 8) continue;  // the natural spline is flat at its ends
    // The interpolating spline through 401 points is off by (pi/800)^4 R/384 < 1e-12 m.
    EXPECT_NEAR(pair.rest_offset.norm(), 1e-3, 1e-11);
  }
}

TEST(ContactGeometry, NodesOutsideTheBandsExtentAreNoCandidates) {
  const Model wire = meshed(straight_line({0, 0, 0}, {0.501, 0, 0}), 25);
  const Model band = meshed(straight_line({0.12, 0, 0}, {0.441, 0, 0}), 16);
  const std::vector<ContactPair> pairs = contact_pairs(wire, band);
  ASSERT_FALSE(pairs.empty());
  EXPECT_EQ(pairs.front().node, 6);
  EXPECT_EQ(pairs.back().node, 22);
  for (const ContactPair& pair : pairs) {
    EXPECT_NEAR(pair.outside_arc_length, pair.inside_arc_length - 0.12, 1e-14);
  }
}

TEST(ContactGeometry, NodeInTheBandsEndPlaneCounts) {
  const Model wire = meshed(straight_line({0, 0, 0}, {0.5, 0, 0}), 10);
  const Model band = meshed(straight_line({0.1, 0, 0}, {0.3, 0, 0}), 5);
  const std::vector<ContactPair> pairs = contact_pairs(wire, band);
  ASSERT_EQ(pairs.size(), 5u);
  EXPECT_EQ(pairs.front().node, 2);
  EXPECT_EQ(pairs.back().node, 6);
}

TEST(ContactGeometry, OfSeveralIntersectionsTheNearestIsTaken) {
  // A hairpin: the plane through the wire's middle cuts it twice, 1 mm and 61 mm away.
  const Centreline hairpin = spline_through({{0, 1e-3, 0},
                                             {0.1, 1e-3, 0},
                                             {0.2, 1e-3, 0},
                                             {0.23, 0.03, 0},
                                             {0.2, 0.061, 0},
                                             {0.1, 0.061, 0},
                                             {0, 0.061, 0}});
  const PlaneCut cut(hairpin, 300);
  const auto s = cut.nearest({0.1, 0, 0}, {1, 0, 0});
  ASSERT_TRUE(s.has_value());
  EXPECT_LT(hairpin.at(*s).position.y(), 5e-3);
  EXPECT_NEAR(hairpin.at(*s).position.x(), 0.1, 1e-15);
}

TEST(ContactGeometry, PlaneThatMissesTheCurveHasNoCut) {
  const PlaneCut cut(straight_line({0, 0, 0}, {0.5, 0, 0}), 10);
  EXPECT_FALSE(cut.nearest({0.6, 0, 0}, {1, 0, 0}).has_value());
  EXPECT_FALSE(cut.nearest({0.2, 0.1, 0}, {0, 1, 0}).has_value());  // parallel to the curve
}

TEST(ContactGeometry, SlidingFollowsTheCutWithoutJumps) {
  // A point carried along the curve crosses mesh nodes; arc length and displacement weights change smoothly
  // (C1 shape functions).
  const Centreline curve = spline_through(spline_points(), 0.68);
  const Model band = meshed(curve, 10, EndCondition::free);
  const PlaneCut cut(curve, 256);
  Eigen::VectorXd wave = Eigen::VectorXd::Zero(band.dof_count());
  for (int i = 0; i < wave.size(); ++i) wave[i] = std::sin(1.0 + i);
  const double step = 1e-6;
  double before = 0.0, slope_before = 0.0;
  for (int i = 0; i < 1000; ++i) {  // 0.0675 .. 0.0685 m, over the node at 0.068
    const double on_wire = 0.0675 + i * step;
    const CurvePoint at = curve.at(on_wire);
    const auto next = cut.nearest(at.position, at.tangent);
    ASSERT_TRUE(next.has_value());
    EXPECT_NEAR(*next, on_wire, 1e-13);
    const double value = point_functional(band, *next / 0.68, Eigen::Vector3d::UnitY()).dot(wave);
    const double slope = (value - before) / step;
    // A jump of the value would be of the size of the wave (1), one of the slope of 1/element = 15.
    if (i > 1) {
      EXPECT_NEAR(slope, slope_before, 0.2);
    }
    before = value;
    slope_before = slope;
  }
}

TEST(ContactGeometry, RigidTranslationOfBothBodiesChangesNothing) {
  const Model wire = meshed(spline_through(spline_points(), 0.68), 12, EndCondition::free);
  const Model band = meshed(spline_through(spline_points(), 0.68), 9, EndCondition::free);
  const Eigen::Vector3d shift(0.3, -0.2, 0.5);
  const auto translation = [&](const Model& model) {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(model.dof_count());
    for (int n = 0; n < q.size() / 6; ++n) q.segment<3>(6 * n) = shift;
    return q;
  };
  for (const ContactPair& pair : contact_pairs(wire, band)) {
    const Eigen::Vector2d change = pair.inside_weights.transpose() * translation(wire) -
                                   pair.outside_weights.transpose() * translation(band);
    EXPECT_LT(change.norm(), 1e-12);  // rounding of the element's shape functions
  }
}

TEST(ContactGeometry, InflectedAndStraightPiecesNeedNoSpecialCare) {
  // An S curve: the curvature passes through zero in the middle, where N and B do not exist.
  const Centreline s_curve =
      spline_through({{0, 0, 0}, {0.15, 0.04, 0}, {0.3, 0, 0}, {0.45, -0.04, 0}, {0.6, 0, 0}});
  for (const ContactPair& pair : contact_pairs(meshed(s_curve, 20), meshed(s_curve, 16))) {
    const Eigen::Vector3d tangent = s_curve.at(pair.inside_arc_length).tangent;
    EXPECT_TRUE(pair.plane_axes.allFinite());
    EXPECT_LT((pair.plane_axes.transpose() * tangent).norm(), 1e-15);
    EXPECT_NEAR(pair.plane_axes.col(0).dot(pair.plane_axes.col(1)), 0.0, 1e-15);
    EXPECT_LT(pair.rest_offset.norm(), 5e-15);
  }
}

TEST(ContactGeometry, RefusesPointsThatDoNotFit) {
  ContactPoint sound;
  sound.law = {ContactLaw::approach, 1e5, 100.0};
  sound.gap = 1e-3;
  sound.inside = Eigen::MatrixX2d::Ones(3, 2);
  EXPECT_NO_THROW(validate({sound}, {3}));
  const std::function<void(ContactPoint&)> faults[] = {
      [](ContactPoint& p) { p.gap = 0.0; },
      [](ContactPoint& p) { p.gap = NAN; },
      [](ContactPoint& p) { p.inside_body = 1; },
      [](ContactPoint& p) { p.inside_body = -1; },
      [](ContactPoint& p) { p.outside_body = 0; },
      [](ContactPoint& p) { p.outside_body = 2; },
      [](ContactPoint& p) { p.inside = Eigen::MatrixX2d::Ones(2, 2); },
      [](ContactPoint& p) { p.outside = Eigen::MatrixX2d::Ones(2, 2); },
      [](ContactPoint& p) { p.rest_offset[0] = NAN; },
      [](ContactPoint& p) { p.motion[1] = INFINITY; },
      [](ContactPoint& p) { p.law.stiffness = -1.0; }};
  for (const auto& fault : faults) {
    ContactPoint point = sound;
    fault(point);
    EXPECT_THROW(validate({point}, {3}), Error);
  }
  EXPECT_THROW(PlaneCut(straight_line({0, 0, 0}, {1, 0, 0}), 0), Error);
}

}  // namespace
}  // namespace struna::fem
