#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/centreline.hpp"

namespace struna::fem {

/// Straight lines from point to point, met by an arc of `radius` [m] at every corner, or of one so much
/// smaller that it takes no more than 0.45 of the shorter line. Throws Error on fewer than two points,
/// coincident neighbours, a line that goes straight back, or a radius that is not positive.
Centreline rounded_polygon(const std::vector<Eigen::Vector3d>& points, double radius);

}  // namespace struna::fem
