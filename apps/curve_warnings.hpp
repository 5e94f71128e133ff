#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/curve_error.hpp"

namespace struna::apps {

inline constexpr double tightest_bend = 5.0;   ///< thicknesses; where beam theory ends
inline constexpr double sharpest_turn = 0.85;  ///< [rad] at one of few points

inline constexpr double likely = 0.75;  ///< probability from which an error is warned of

/// What is told of a body's centreline through points.
struct CurveReport {
  fem::CurveError error;
  std::string statement;              ///< how far natural frequencies are off; empty for a straight line
  std::vector<std::string> warnings;  ///< where the centreline can hardly be what was meant
};

/// Warnings: natural frequencies are likely off by more than fem::curve_tolerance; few points
/// that turn by more than sharpest_turn at one of them, or lie straight beside a bend; two points so near
/// each other that they tell no direction; a bend tighter than tightest_bend thicknesses (a kink, points in
/// the wrong order); of the last two only where they matter, to natural frequencies or to few points.
/// `length`: as given; 0: the points' own.
CurveReport report_curve(const fem::Body& body, const std::vector<Eigen::Vector3d>& points, double length);

}  // namespace struna::apps
