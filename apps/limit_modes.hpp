#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Two modes side by side (200 Hz, loss factor 0.02, two outputs in which their shapes differ) among two
/// distant ones, over their spacing, noise and lines per half-power bandwidth. A trial for each of the two:
/// the worse of natural frequency (in bandwidths) and loss factor (relative), in units of the standard
/// error stated. A mode that is not found is judged by the mode within a bandwidth that stands for it, and
/// counts as refused where there is none.
LimitMap circle_limits(const LimitRun& run);      ///< --method circle
LimitMap multi_mode_limits(const LimitRun& run);  ///< --method auto

}  // namespace struna::apps
