#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Two straight pieces with a tight bend between them, read off at points equally far apart, against the beam
/// that bends so: points, angle and radius of the bend, whose place is drawn. First, curves that are what the
/// points draw, as gently bent all along.
LimitMap kink_limits(const LimitRun& run);

/// An arc with a second point next to one of its points: points, their distance, and by how much the second
/// is off the arc, in any direction.
LimitMap near_point_limits(const LimitRun& run);

}  // namespace struna::apps
