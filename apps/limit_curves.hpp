#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Circular arcs told by points: number of points x error of each x angle of the arc; natural frequencies
/// against the arc's own.
LimitMap curve_limits(const LimitRun& run);

}  // namespace struna::apps
