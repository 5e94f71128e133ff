#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/body.hpp"

namespace struna::fem {

/// How far the natural frequencies of a body are off because its centreline was drawn through points, the
/// natural spline that spline_through() makes.
struct CurveError {
  Eigen::ArrayXd sigma;      ///< of the first elastic frequencies, relative; empty where there is none
  double worst = 0.0;        ///< the same of the worst of them: root mean square of its error
  double probability = 0.0;  ///< that the worst is off by more than the tolerance
  double scatter = 0.0;      ///< of the points across the curve [m]
  double radius = 0.0;       ///< the smallest of the likeliest curve [m]; 0 where there is none
  bool digitised = false;    ///< whether the points are enough to be taken for read off a curve
};
inline constexpr int curve_modes = 6;
inline constexpr double curve_tolerance = 0.005;
inline constexpr std::size_t fewest_digitised = 8;

/// `points` and `length` (0: the points' own) are those of the body's centreline. From fewest_digitised
/// points on: against curves that the points leave possible (fem/smooth_curve), which tell both what they
/// scatter and what they are too few for; where one bend lies between points of which the others are all but
/// straight, by how far off a tight bend there would be, if that is more or the others are straight
/// altogether, every error up to that being alike. Fewer points are what the curve is drawn by, and tell no
/// error; sigma is then how far those of a body are that runs straight on to tight bends, at the points or
/// between two of them: a distance, not a deviation. Springs of ends do not count: clamped ones as rigid,
/// pinned ones as free to turn. 0 for a straight line. Costs 10 to 50 ms.
CurveError curve_error(const Body& body, const std::vector<Eigen::Vector3d>& points, double length);

}  // namespace struna::fem
