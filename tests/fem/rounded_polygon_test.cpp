#include "fem/rounded_polygon.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/centreline.hpp"
#include "tests/message_of.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using tests::message_of;
using Points = std::vector<Vector3d>;

constexpr double pi = std::numbers::pi;

TEST(RoundedPolygon, IsTwoLinesAndAQuarterCircleAtARightAngle) {
  const Centreline curve = rounded_polygon({{0, 0, 0}, {1, 0, 0}, {1, 2, 0}}, 0.1);
  // Two cuts of R tan(45 deg) for an arc of R pi/2.
  EXPECT_NEAR(curve.length(), 3.0 - 0.2 + 0.05 * pi, 1e-14);
  EXPECT_FALSE(curve.is_straight());
  const CurvePoint middle = curve.at(0.9 + 0.025 * pi);
  EXPECT_LT((middle.position - Vector3d(0.9 + 0.1 * std::sqrt(0.5), 0.1 - 0.1 * std::sqrt(0.5), 0)).norm(),
            1e-14);
  EXPECT_LT((middle.tangent - Vector3d(std::sqrt(0.5), std::sqrt(0.5), 0)).norm(), 1e-14);
  EXPECT_LT((middle.curvature - 10.0 * Vector3d(-std::sqrt(0.5), std::sqrt(0.5), 0)).norm(), 1e-12);
  EXPECT_LT((curve.at(curve.length()).position - Vector3d(1, 2, 0)).norm(), 1e-14);
  EXPECT_EQ(curve.at(0.5).curvature.norm(), 0.0);
}

TEST(RoundedPolygon, HasTheSlopeThatItsPositionsHave) {
  const Centreline curve =
      rounded_polygon({{0, 0, 0}, {0.3, 0.1, 0}, {0.4, 0.4, 0.2}, {0.9, 0.4, -0.1}}, 0.05);
  constexpr double step = 1e-6;
  for (double s = step; s < curve.length() - step; s += 0.01) {
    const Vector3d slope = (curve.at(s + step).position - curve.at(s - step).position) / (2.0 * step);
    // Where curvature jumps, by 1/0.05, the difference is off by half of step/0.05; elsewhere by rounding.
    EXPECT_LT((slope - curve.at(s).tangent).norm(), 2e-5) << s;
  }
}

TEST(RoundedPolygon, TakesSmallerArcsWhereLinesAreShort) {
  const Centreline curve = rounded_polygon({{0, 0, 0}, {1, 0, 0}, {1, 0.1, 0}, {2, 0.1, 0}}, 0.5);
  double largest = 0.0;
  for (double s = 0.0; s < curve.length(); s += 0.001)
    largest = std::max(largest, curve.at(s).curvature.norm());
  EXPECT_NEAR(largest, 1.0 / 0.045, 1e-9);  // 0.45 of the short line, at right angles
}

TEST(RoundedPolygon, IsStraightWithoutCorners) {
  const Centreline curve = rounded_polygon({{0, 0, 0}, {0.2, 0, 0}, {0.7, 0, 0}}, 0.1);
  EXPECT_TRUE(curve.is_straight());
  EXPECT_NEAR(curve.length(), 0.7, 1e-15);
}

TEST(RoundedPolygon, RefusesWhatHasNoCorner) {
  EXPECT_THAT(message_of([] { rounded_polygon({{0, 0, 0}}, 0.1); }), HasSubstr("at least 2 points, got 1"));
  EXPECT_THAT(message_of([] {
                rounded_polygon({{0, 0, 0}, {0, 0, 0}}, 0.1);
              }),
              HasSubstr("must differ, not 1 and 2"));
  EXPECT_THAT(message_of([] {
                rounded_polygon({{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}}, 0.1);
              }),
              HasSubstr("straight back, as at point 2"));
  EXPECT_THAT(message_of([] {
                rounded_polygon({{0, 0, 0}, {1, 0, 0}}, 0.0);
              }),
              HasSubstr("radius must be positive"));
}

}  // namespace
}  // namespace struna::fem
