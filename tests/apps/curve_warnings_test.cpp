// What is told of centrelines through digitised points, and the map of where that is right.
#include "apps/curve_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/limit_curves.hpp"
#include "apps/limit_kinks.hpp"

namespace struna::apps {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using Points = std::vector<Eigen::Vector3d>;

fem::Body body_along(fem::Centreline centreline) {
  return {"wire", std::move(centreline), fem::solid_circle(0.0032), 7650.0, 0.3, {}};
}

CurveReport report_of(const Points& points, double length = 0.0) {
  return report_curve(body_along(fem::spline_through(points, length)), points, length);
}

std::vector<std::string> warnings_of(const Points& points, double length = 0.0) {
  return report_of(points, length).warnings;
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
}

TEST(CurveWarnings, CurvesDrawnByFewPointsHaveNone) {
  EXPECT_THAT(warnings_of({{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}}), IsEmpty());
  EXPECT_THAT(warnings_of({{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}, {0.62, -0.02, 0.16}}),
              IsEmpty());
  EXPECT_THAT(warnings_of(arc_points(5, 0.0)), IsEmpty());
}

TEST(CurveWarnings, ZigzagsLeaveTheCurveOpen) {
  EXPECT_THAT(warnings_of(arc_points(24, 2e-3)), ElementsAre(HasSubstr("leave open how the curve runs")));
  EXPECT_GT(report_of(arc_points(24, 2e-3)).error.worst, report_of(arc_points(24, 1e-4)).error.worst);
}

TEST(CurveWarnings, StatementTellsTheErrorOrTheDistance) {
  EXPECT_THAT(report_of(arc_points(24, 0.0)).statement,
              StartsWith("body 'wire': curve through 24 points that scatter by "));
  EXPECT_THAT(report_of(arc_points(4, 0.0)).statement, HasSubstr("curve drawn by 4 points"));
  EXPECT_EQ(report_of({{0, 0, 0}, {1, 0, 0}}).statement, "");
}

TEST(CurveWarnings, SharpTurnsOfFewPointsAreToldOf) {
  EXPECT_THAT(warnings_of({{0, 0, 0}, {0.3, 0, 0}, {0.4, 0.3, 0}}),
              ElementsAre(HasSubstr("turn by 1.2 rad at point 2 alone")));
  EXPECT_THAT(warnings_of({{0, 0, 0}, {0.15, 0, 0}, {0.3, 0, 0}, {0.44, 0.05, 0}, {0.58, 0.1, 0}}),
              ElementsAre(HasSubstr("run straight on at point 2 beside a bend")));
}

TEST(CurveWarnings, KinksAndPointsNearEachOtherAreTightBends) {
  const Points kink = {{0, 0, 0}, {0.3, 0, 0}, {0.31, 0, 0}, {0.31, 0.01, 0}, {0.31, 0.3, 0}};
  EXPECT_THAT(warnings_of(kink), Contains(HasSubstr("bend it to a radius")));
  const Points near_points = {{0, 0, 0}, {0.3, 0.02, 0}, {0.3001, 0.0203, 0}, {0.6, 0, 0}};
  EXPECT_THAT(warnings_of(near_points), Contains(HasSubstr("too near each other")));
  const Points wrong_order = {{0, 0, 0}, {0.2, 0.02, 0}, {0.4, 0.03, 0}, {0.3, 0.03, 0}, {0.6, 0, 0}};
  EXPECT_THAT(warnings_of(wrong_order), Contains(HasSubstr("wrong order")));
}

TEST(Limits, CurvesThroughScatteredPointsAreToldOf) {
  LimitRun run;
  run.seeds = 2;
  run.every = 2;
  const LimitMap map = curve_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_EQ(all.wrong_flagged, all.wrong);  // one or none
  EXPECT_LE(all.wrong, 1);
  EXPECT_LE(all.false_alarm_share(), 0.12);  // of some 40; 4 % of the whole map
  EXPECT_GT(all.right, 20);
  long off = 0, told = 0;  // by the tolerance alone
  for (const LimitTrial& t : map.trials) {
    off += t.error > t.tolerance;
    told += t.error > t.tolerance && !t.flags.empty();
  }
  EXPECT_GT(off, 30);
  EXPECT_GE(told, 0.95 * static_cast<double>(off));
  LimitMap fine = map;
  std::erase_if(fine.trials, [](const LimitTrial& t) { return t.at[0] < 24.0 || t.at[1] > 0.03; });
  EXPECT_EQ(count_of(fine).wrong, 0);
  EXPECT_EQ(count_of(fine).right_flagged, 0);
}

TEST(Limits, BendsBetweenPointsAreToldOf) {
  LimitRun run;
  run.seeds = 1;
  run.every = 2;
  const LimitMap map = kink_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_EQ(all.wrong_flagged, all.wrong);
  EXPECT_LE(10 * all.wrong, all.uncertain);
  EXPECT_GT(all.right, 10);
  EXPECT_LE(all.false_alarm_share(), 0.1);  // 3 to 4 % of the whole map
  long off = 0, told = 0, drawn = 0, drawn_flagged = 0;
  for (const LimitTrial& t : map.trials) {
    off += t.error > t.tolerance;
    told += t.error > t.tolerance && (!t.flags.empty() || t.sigma > t.tolerance);  // or stated
    const bool few = t.at[2] == 0.0 && t.at[0] < 8.0 && t.at[1] / (t.at[0] - 1.0) < 0.6;
    drawn += few;
    drawn_flagged += few && !t.flags.empty();
  }
  EXPECT_GT(off, 20);
  EXPECT_EQ(told, off);
  EXPECT_GT(drawn, 2);
  EXPECT_EQ(drawn_flagged, 0);
}

TEST(Limits, PointsNextToEachOtherAreToldOfOrRefused) {
  LimitRun run;
  run.seeds = 1;
  run.every = 3;
  const LimitMap map = near_point_limits(run);
  const LimitCount all = count_of(map);
  EXPECT_EQ(all.wrong_flagged, all.wrong);
  EXPECT_GT(all.refused, 0);
  EXPECT_GT(all.right, 5);
  EXPECT_LE(all.false_alarm_share(), 0.15);
  for (const LimitTrial& t : map.trials) EXPECT_EQ(t.refused, t.at[1] == 0.0 && t.at[2] == 0.0);
}

}  // namespace
}  // namespace struna::apps
