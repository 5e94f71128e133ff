#include "fem/smooth_curve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/fem/digitised_curves.hpp"
#include "tests/message_of.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using testing::digitised;
using Points = std::vector<Vector3d>;

/// Farthest that the smooth curve is from the circle of the arc [m].
double off_arc(const SmoothCurve& curve, double angle) {
  const double radius = 0.68 / angle;
  double worst = 0.0;
  for (int i = 0; i <= 300; ++i) {
    const Vector3d at = curve.at(curve.t.back() * i / 300) - Vector3d(0, radius, 0);
    worst = std::max(worst, std::hypot(at.head<2>().norm() - radius, at.z()));
  }
  return worst;
}

TEST(SmoothCurve, IsTheArcWhosePointsItWasGiven) {
  for (const double angle : {0.5, 1.5, 4.5}) {
    const auto curves = curves_through(digitised(circular_arc(0.68, angle), 12, 0.0, 1), 0);
    // A natural spline is off by 1/384 of the fourth power of the angle between points at best: 1e-2 mm at
    // 4.5 rad, and by far more at its ends.
    EXPECT_LT(off_arc(curves.likeliest, angle), 2e-5) << angle;
    EXPECT_LT(curves.likeliest.scatter, 2e-5) << angle;
    EXPECT_NEAR(curves.turn, angle, 0.02 * angle);
  }
}

TEST(SmoothCurve, TakesOutMostOfTheScatterAndTellsIt) {
  for (const double angle : {0.5, 4.5}) {
    const Centreline arc = circular_arc(0.68, angle);
    double square = 0.0, off_square = 0.0;
    constexpr int draws = 30;
    for (unsigned seed = 1; seed <= draws; ++seed) {
      const auto curve = curves_through(digitised(arc, 48, 3e-4, seed), 0).likeliest;
      square += std::pow(curve.scatter / 3e-4, 2) / draws;
      off_square += std::pow(off_arc(curve, angle) / 3e-4, 2) / draws;
    }
    // chi^2 of 90 degrees of freedom each, 30 times: 2.7 % in the variance; what arcs take up less or more of
    // it as the ratio is estimated, as much again.
    EXPECT_NEAR(square, 1.0, 0.15) << angle;
    EXPECT_LT(off_square, 1.5) << angle;  // the farthest, where a point itself is off by 2.5 sigma somewhere
  }
}

TEST(SmoothCurve, DrawnCurvesSpreadAsFarAsTheLikeliestIsOff) {
  double off = 0.0, spread = 0.0;
  const Centreline arc = circular_arc(0.68, 1.5);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto curves = curves_through(digitised(arc, 24, 3e-4, seed), 8);
    const double middle = 0.5 * curves.likeliest.t.back();
    const double z = curves.likeliest.at(middle).z();
    off += z * z;
    for (const SmoothCurve& curve : curves.drawn) spread += std::pow(curve.at(middle).z() - z, 2) / 8.0;
  }
  // Each the mean of 20 squares: 32 % and 11 %.
  EXPECT_NEAR(std::sqrt(spread / off), 1.0, 0.5);
}

TEST(SmoothCurve, TakesPointsNearEachOtherForOne) {
  Points points = digitised(circular_arc(0.68, 1.5), 9, 0.0, 1);
  points.insert(points.begin() + 4, points[4] + Vector3d(1e-6, 0, 0));
  const auto curve = curves_through(points, 0).likeliest;
  EXPECT_EQ(curve.t.size(), 9u);
  EXPECT_LT(off_arc(curve, 1.5), 1e-4);
}

TEST(SmoothCurve, CentrelineAlongItHasTheLengthAskedFor) {
  const auto curve = curves_through(digitised(circular_arc(0.68, 1.5), 24, 1e-4, 1), 0).likeliest;
  EXPECT_NEAR(centreline_along(curve).length(), 0.68, 1e-4);
  EXPECT_NEAR(centreline_along(curve, 0.7).length(), 0.7, 1e-12);
}

TEST(SmoothCurve, RefusesTooFewPoints) {
  const Points four = {{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {3, 3, 0}};
  EXPECT_THAT(tests::message_of([&] { curves_through(four, 1); }),
              ::testing::HasSubstr("at least 5 points that are apart, got 4"));
}

}  // namespace
}  // namespace struna::fem
