#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/body.hpp"

namespace struna::apps {

/// How far natural frequencies, the worst of the first six, hang on how the curve runs through points that it
/// was digitised at, relative: against a second curve, of the same length where one is given, through the
/// points freed of what they scatter and through further ones between them. Scatter: of the difference of a
/// point from the cubic through its two neighbours on either side, the share that is its own if all five are
/// equally uncertain. Between: the cubic through the four nearest points, which unlike the natural spline is
/// not straight at its ends. Both are of the order of the true error (docs/limits.md). 0 for a straight line.
/// Ends count as rigid. Fewer points than fewest_digitised are taken for what the curve is drawn by: 0.
double curve_doubt(const fem::Body& body, const std::vector<Eigen::Vector3d>& points, double length);

/// Smallest radius of curvature of the centreline [m]; infinite for a straight one.
double smallest_radius(const fem::Centreline& centreline);

/// Told where a body's centreline can hardly be what was meant: natural frequencies hang on how it runs
/// through its points (curve_doubt), or a bend is tighter than tightest_bend thicknesses, where beam theory
/// ends (a kink, points in the wrong order), or two points are so near each other that they tell no
/// direction. Thickness: the diameter of the solid circle with the section's radius of gyration. `length`: as
/// given; 0: the points' own.
std::vector<std::string> curve_warnings(const fem::Body& body, const std::vector<Eigen::Vector3d>& points,
                                        double length);
inline constexpr double curve_tolerance = 0.005;  ///< of natural frequencies
inline constexpr std::size_t fewest_digitised = 8;
inline constexpr double tightest_bend = 5.0;

}  // namespace struna::apps
