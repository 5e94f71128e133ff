#include "fem/curve_shape.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace struna::fem {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using Points = std::vector<Eigen::Vector3d>;

TEST(CurveShape, SmallestRadiusIsThatOfAnArcAndInfiniteOfALine) {
  EXPECT_EQ(smallest_radius(straight_line({0, 0, 0}, {1, 0, 0})), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(smallest_radius(circular_arc(0.6, 1.5)), 0.4, 1e-12);
}

TEST(CurveShape, ThicknessIsTheDiameterOfASolidCircle) {
  EXPECT_NEAR(thickness(solid_circle(0.0032)), 0.0032, 1e-15);
}

TEST(CurveShape, TurnsAreAnglesBetweenChords) {
  EXPECT_THAT(turns({{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {1, 3, 0}, {0, 4, 0}}),
              ElementsAre(DoubleNear(0.5 * std::numbers::pi, 1e-15), 0.0,
                          DoubleNear(0.25 * std::numbers::pi, 1e-15)));
}

TEST(CurveShape, PointsNearEachOtherAreStrayWhereTheirDirectionIsOff) {
  const Points aside = {{0, 0, 0}, {0.3, 0.02, 0}, {0.3001, 0.0203, 0}, {0.6, 0, 0}};
  EXPECT_EQ(stray_pair(aside), 1);
  const Points along = {{0, 0, 0}, {0.3, 0.02, 0}, {0.3001, 0.02, 0}, {0.6, 0.04, 0}};
  EXPECT_EQ(stray_pair(along), -1);
}

TEST(CurveShape, StraightPiecesAreToldBesideABendOnly) {
  EXPECT_EQ(straight_beside_bend({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 1, 0}, {4, 2, 0}}), 1);
  EXPECT_EQ(straight_beside_bend({{0, 0, 0}, {1, 0.1, 0}, {2, 0.4, 0}, {3, 0.9, 0}, {4, 1.6, 0}}), -1);
  EXPECT_EQ(straight_beside_bend({{0, 0, 0}, {1, 0, 0}, {2, 1, 0}}), -1);  // nothing beside it
}

TEST(CurveShape, ALoneBendIsOverOnePointOrTwo) {
  const Points at_point = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {3, 2, 0}, {3, 3, 0}};
  ASSERT_TRUE(lone_bend(at_point).has_value());
  EXPECT_EQ(lone_bend(at_point)->rest, 0.0);
  const Points between = {{0, 0, 0},     {1, 0, 0},     {2, 0, 0},  {2.5, 0.5, 0},
                          {2.5, 1.5, 0}, {2.5, 2.5, 0}, {2.5, 3, 0}};
  ASSERT_TRUE(lone_bend(between).has_value());
  EXPECT_EQ(lone_bend(between)->point, 2);
  const Points arc = {{0, 0, 0}, {1, 0.1, 0}, {2, 0.4, 0}, {3, 0.9, 0}, {4, 1.6, 0}, {5, 2.5, 0}};
  EXPECT_FALSE(lone_bend(arc).has_value());
  EXPECT_FALSE(lone_bend({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}}).has_value());  // too few
}

}  // namespace
}  // namespace struna::fem
