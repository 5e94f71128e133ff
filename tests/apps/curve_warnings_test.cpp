// What is told of centrelines through digitised points, and the map of where that is right.
#include "apps/curve_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "apps/limit_curves.hpp"

namespace struna::apps {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Points = std::vector<Eigen::Vector3d>;

fem::Body body_along(fem::Centreline centreline) {
  return {"wire", std::move(centreline), fem::solid_circle(0.0032), 7650.0, 0.3, {}};
}

std::vector<std::string> warnings_of(const Points& points, double length = 0.0) {
  return curve_warnings(body_along(fem::spline_through(points, length)), points, length);
}

/// Every other inner point of an arc moved outwards by `zigzag` [m], its neighbours inwards.
Points arc_points(int count, double zigzag) {
  const fem::Centreline arc = fem::circular_arc(0.68, 1.5);
  Points points;
  for (int i = 0; i < count; ++i) {
    const fem::CurvePoint at = arc.at(arc.length() * i / (count - 1));
    const double sign = i == 0 || i + 1 == count ? 0.0 : i % 2 == 0 ? 1.0 : -1.0;
    points.push_back(at.position + sign * zigzag * at.curvature.normalized());
  }
  return points;
}

TEST(CurveWarnings, SmoothPointsHaveNone) {
  EXPECT_THAT(warnings_of(arc_points(24, 0.0)), IsEmpty());
  EXPECT_THAT(warnings_of({{0, 0, 0}, {0.68, 0, 0}}), IsEmpty());
  EXPECT_THAT(warnings_of({{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}, {0.62, -0.02, 0.16}}),
              IsEmpty());
  EXPECT_EQ(curve_doubt(body_along(fem::straight_line({0, 0, 0}, {1, 0, 0})), {{0, 0, 0}, {1, 0, 0}}, 0.0),
            0.0);
}

TEST(CurveWarnings, DoubtIsThatOfTheZigzag) {
  // 29.6 mm apart: a polyline would be longer by 2 (1/29.6)^2 for each mm of zigzag, a spline by more.
  const fem::Body zigzag = body_along(fem::spline_through(arc_points(24, 1e-3)));
  const double doubt = curve_doubt(zigzag, arc_points(24, 1e-3), 0.0);
  EXPECT_GT(doubt, 2.0 * 2.0 / (29.6 * 29.6));
  EXPECT_LT(doubt, 0.05);
  EXPECT_THAT(warnings_of(arc_points(24, 1e-3)), ElementsAre(HasSubstr("leave open how the curve runs")));
  EXPECT_LT(curve_doubt(zigzag, arc_points(24, 1e-4), 0.0), doubt);
}

TEST(CurveWarnings, KinksAndPointsNearEachOtherAreTightBends) {
  EXPECT_EQ(smallest_radius(fem::straight_line({0, 0, 0}, {1, 0, 0})),
            std::numeric_limits<double>::infinity());
  EXPECT_NEAR(smallest_radius(fem::circular_arc(0.6, 1.5)), 0.4, 1e-12);
  const Points kink = {{0, 0, 0}, {0.3, 0, 0}, {0.31, 0, 0}, {0.31, 0.01, 0}, {0.31, 0.3, 0}};
  EXPECT_THAT(warnings_of(kink), ElementsAre(HasSubstr("bend it to a radius")));
  const Points near_points = {{0, 0, 0}, {0.3, 0.02, 0}, {0.3001, 0.0203, 0}, {0.6, 0, 0}};
  EXPECT_THAT(warnings_of(near_points), ElementsAre(HasSubstr("too near each other")));
  const Points wrong_order = {{0, 0, 0}, {0.2, 0.02, 0}, {0.4, 0.03, 0}, {0.3, 0.03, 0}, {0.6, 0, 0}};
  EXPECT_THAT(warnings_of(wrong_order), ElementsAre(HasSubstr("wrong order")));
}

TEST(Limits, CurvesThroughScatteredPointsAreToldOf) {
  LimitRun run;
  run.seeds = 2;
  run.every = 2;
  const LimitMap map = curve_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_GE(all.flagged_share(), 0.85);  // of some 60; 0.95 of the whole map
  EXPECT_GT(all.wrong, 30);
  EXPECT_LE(all.false_alarm_share(), 0.2);
  EXPECT_GT(all.right, 20);
  LimitMap fine = map;
  std::erase_if(fine.trials, [](const LimitTrial& t) { return t.at[0] < 24.0 || t.at[1] > 0.03; });
  EXPECT_EQ(count_of(fine).wrong, 0);
  EXPECT_EQ(count_of(fine).right_flagged, 0);
}

}  // namespace
}  // namespace struna::apps
