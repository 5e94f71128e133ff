#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fem/body.hpp"

namespace struna::fem {

/// Smallest radius of curvature of the centreline [m], among 600 equally spaced places; infinite for a
/// straight one.
double smallest_radius(const Centreline& centreline);

/// Diameter of the solid circle with this radius of gyration [m].
double thickness(const Section& section);

/// By how much the lines from point to point turn at each inner point [rad], 0 to pi.
std::vector<double> turns(const std::vector<Eigen::Vector3d>& points);

/// The two neighbours, by the place of the first, that are so near each other beside both chords next to them
/// and so far off their direction that it can only be the points' error (a twentieth, 0.2 rad); -1 where
/// there are none.
int stray_pair(const std::vector<Eigen::Vector3d>& points);

/// The inner point at which the lines hardly turn, less than a twentieth of what they do at an inner point
/// beside it: there is a straight piece next to a bend, and a spline through them swings about it. -1 where
/// there is none.
int straight_beside_bend(const std::vector<Eigen::Vector3d>& points);

/// A bend that lies between points: over one inner point, or two, lines turn by ten times as much as at the
/// median one, with the points around all but straight.
struct LoneBend {
  int point = 0;      ///< place of the first
  double rest = 0.0;  ///< turn at the median inner point [rad]
};
std::optional<LoneBend> lone_bend(const std::vector<Eigen::Vector3d>& points);

}  // namespace struna::fem
