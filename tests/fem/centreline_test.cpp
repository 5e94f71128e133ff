#include "fem/centreline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fem/error.hpp"
#include "fem/quadrature.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;

/// Arc length between two stations from the curve's own points: the polyline's length, extrapolated twice
/// (h^2, h^4).
double measured_length(const Centreline& curve, double from, double to) {
  const auto polyline = [&](int steps) {
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
      sum += (curve.at(from + (to - from) * (i + 1) / steps).position -
              curve.at(from + (to - from) * i / steps).position)
                 .norm();
    }
    return sum;
  };
  const double a = polyline(64);
  const double b = polyline(128);
  const double c = polyline(256);
  const double ab = b + (b - a) / 3.0;
  const double bc = c + (c - b) / 3.0;
  return bc + (bc - ab) / 15.0;
}

TEST(Quadrature, IntegratesPolynomialsUpToItsDegree) {
  const GaussRule rule = gauss_legendre(5);
  for (int degree = 0; degree <= 9; ++degree) {
    EXPECT_NEAR((rule.weight.array() * rule.node.array().pow(degree)).sum(), 1.0 / (degree + 1),
                1e-15);  // rounding
  }
  EXPECT_GT(std::abs((rule.weight.array() * rule.node.array().pow(10)).sum() - 1.0 / 11.0), 1e-7);
}

TEST(Quadrature, RunningIntegralIsExactForThePolynomialThroughTheNodes) {
  const GaussRule rule = gauss_legendre(4);
  const Eigen::VectorXd integral = integration_matrix(rule.node) * rule.node.array().pow(3).matrix();
  EXPECT_LT((integral.array() - rule.node.array().pow(4) / 4.0).abs().maxCoeff(), 1e-16);
}

TEST(Centreline, LineHasUnitTangentAndNoCurvature) {
  const Centreline line = straight_line({1.0, 2.0, 3.0}, {1.0, 2.0, 5.0});
  EXPECT_TRUE(line.is_straight());
  EXPECT_DOUBLE_EQ(line.length(), 2.0);
  EXPECT_TRUE(line.at(0.5).position.isApprox(Vector3d(1.0, 2.0, 3.5)));
  EXPECT_TRUE(line.at(0.5).tangent.isApprox(Vector3d::UnitZ()));
  EXPECT_EQ(line.at(0.5).curvature.norm(), 0.0);
}

TEST(Centreline, ArcMeetsItsClosedForm) {
  const double angle = 2.0 * std::numbers::pi / 3.0;
  const Centreline arc = circular_arc(0.68, angle);
  const double radius = 0.68 / angle;
  const CurvePoint end = arc.at(0.68);
  EXPECT_NEAR(end.position.x(), radius * std::sin(angle), 1e-15);  // rounding
  EXPECT_NEAR(end.position.y(), radius * (1.0 - std::cos(angle)), 1e-15);
  EXPECT_NEAR(end.curvature.norm(), 1.0 / radius, 1e-14);
  EXPECT_NEAR(end.curvature.dot(end.tangent), 0.0, 1e-14);
}

TEST(Centreline, SplineHasTheReferenceArcLength) {
  EXPECT_NEAR(spline_through(testing::spline_points()).length(), 0.6385027339553294, 2e-15);  // rounding
}

TEST(Centreline, SplineIsScaledAboutItsFirstPointToTheWantedLength) {
  std::vector<Vector3d> points = testing::spline_points();
  for (Vector3d& point : points) point += Vector3d(1.0, -2.0, 0.5);
  const Centreline scaled = spline_through(points, 0.68);
  EXPECT_NEAR(scaled.length(), 0.68, 3e-15);
  EXPECT_LT((scaled.at(0.0).position - points.front()).norm(), 1e-15);
  const Vector3d end = points.front() + 1.0649915244490933 * (points.back() - points.front());
  EXPECT_LT((scaled.at(scaled.length()).position - end).norm(), 2e-15);
}

TEST(Centreline, SplinePassesThroughItsPoints) {
  const std::vector<Vector3d> points = testing::spline_points();
  const Centreline curve = spline_through(points);
  double station = 0.0;
  for (const Vector3d& point : points) {
    // The nearest station by bisection on the distance along the tangent.
    double low = station;
    double high = curve.length();
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      const CurvePoint at = curve.at(middle);
      ((point - at.position).dot(at.tangent) > 0.0 ? low : high) = middle;
    }
    station = 0.5 * (low + high);
    EXPECT_LT((curve.at(station).position - point).norm(), 1e-14);
  }
}

TEST(Centreline, ArcLengthInversionIsExactToRounding) {
  // A gentle curve, and one with a sharp bend and very unequal chords.
  const std::vector<Vector3d> sharp = {
      {0, 0, 0}, {0.3, 0, 0}, {0.31, 0.02, 0}, {0.3, 0.3, 0.1}, {0.9, 0.3, 0.0}};
  for (const Centreline& curve : {spline_through(testing::spline_points(), 0.68), spline_through(sharp)}) {
    const double length = curve.length();
    for (int i = 0; i < 40; ++i) {
      // Stations in steps short enough for the polyline's extrapolation to reach 1e-13.
      const double from = length * i / 40.0;
      const double to = length * (i + 1) / 40.0;
      EXPECT_NEAR(measured_length(curve, from, to), to - from, 1e-13 * length);
    }
  }
}

TEST(Centreline, TangentAndCurvatureAreDerivativesByArcLength) {
  const Centreline curve = spline_through(testing::spline_points(), 0.68);
  const double h = 1e-4;
  for (const double s : {0.05, 0.17, 0.31, 0.4, 0.55, 0.66}) {
    const CurvePoint at = curve.at(s);
    const Vector3d slope = (curve.at(s + h).position - curve.at(s - h).position) / (2.0 * h);
    const Vector3d bend = (curve.at(s + h).tangent - curve.at(s - h).tangent) / (2.0 * h);
    EXPECT_NEAR(at.tangent.norm(), 1.0, 1e-15);
    EXPECT_LT((at.tangent - slope).norm(), 1e-6);   // h^2/6 r''' of central differences
    EXPECT_LT((at.curvature - bend).norm(), 1e-4);  // the same, one order higher
    EXPECT_NEAR(at.curvature.dot(at.tangent), 0.0, 1e-13);
  }
}

TEST(Centreline, NaturalSplineHasNoCurvatureAtItsEnds) {
  const Centreline curve = spline_through(testing::spline_points(), 0.68);
  EXPECT_LT(curve.at(0.0).curvature.norm(), 1e-12);
  EXPECT_LT(curve.at(curve.length()).curvature.norm(), 1e-12);
}

TEST(Centreline, TwoPointsAndCollinearPointsInOrderAreStraight) {
  EXPECT_TRUE(spline_through({{0, 0, 0}, {1, 2, 3}}).is_straight());
  const Centreline line = spline_through({{0, 0, 0}, {0.1, 0.2, 0.3}, {1, 2, 3}}, 2.0);
  EXPECT_TRUE(line.is_straight());
  EXPECT_NEAR(line.length(), 2.0, 1e-15);
  EXPECT_FALSE(spline_through({{0, 0, 0}, {0.1, 0.2, 0.31}, {1, 2, 3}}).is_straight());
}

TEST(Centreline, RefusesWhatIsNotACurve) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<Vector3d>> refused = {
      {},
      {{0, 0, 0}},
      {{0, 0, 0}, {0, 0, 0}},
      {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0}},
      {{0, 0, 0}, {1, nan, 0}},
      {{0, 0, 0}, {1, std::numeric_limits<double>::infinity(), 0}},
      {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {2, 0, 0}},  // turns back on itself: a cusp
  };
  for (const auto& points : refused) EXPECT_THROW(spline_through(points), Error);
  EXPECT_THROW(spline_through(testing::spline_points(), -1.0), Error);
  EXPECT_THROW(spline_through(testing::spline_points(), nan), Error);
  EXPECT_THROW(straight_line({1, 1, 1}, {1, 1, 1}), Error);
  EXPECT_THROW(circular_arc(0.0, 1.0), Error);
  EXPECT_THROW(circular_arc(1.0, 0.0), Error);
  EXPECT_THROW(circular_arc(1.0, 7.0), Error);
}

TEST(Centreline, RefusesStationsOutsideButNotRounding) {
  const Centreline curve = spline_through(testing::spline_points(), 0.68);
  EXPECT_THROW(curve.at(-1e-6), Error);
  EXPECT_THROW(curve.at(0.681), Error);
  EXPECT_THROW(curve.at(std::numeric_limits<double>::quiet_NaN()), Error);
  EXPECT_NO_THROW(curve.at(curve.length() * (1.0 + 1e-15)));
}

}  // namespace
}  // namespace struna::fem
