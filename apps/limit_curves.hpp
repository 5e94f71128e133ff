#pragma once

#include <Eigen/Core>
#include <vector>

#include "apps/limit_map.hpp"
#include "fem/body.hpp"

namespace struna::apps {

/// The wire of these maps.
inline constexpr double curve_length = 0.68;      ///< [m]
inline constexpr double curve_diameter = 0.0032;  ///< [m]
inline constexpr const char* curve_quantity = "natural frequency (relative): the worst of six";

/// lambda of the six lowest modes of the wire along this curve, clamped.
Eigen::VectorXd curve_eigenvalues(const fem::Centreline& centreline, int elements);

/// Error, stated standard error and flags of the curve through the points, or that it is refused; `truth`:
/// lambda of the curve that was meant.
void judge_curve(const std::vector<Eigen::Vector3d>& points, const Eigen::VectorXd& truth, LimitTrial& trial);

/// Points read off an arc with errors: their number, size of the errors, angle of the arc.
LimitMap curve_limits(const LimitRun& run);

}  // namespace struna::apps
