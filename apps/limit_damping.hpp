#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Structural damping in time: a straight wire between two clamps, E = 120 GPa (f/300 Hz)^n and eta = eta_0
/// (f/300 Hz)^s, shaken by a multisine from 20 to 1000 Hz; the far support's force over the settled period
/// (relative rms) against the harmonic response in closed form. Axes: eta_0, n, s. Flagged: the warning that
/// the pair belongs to no causal material.
LimitMap damping_in_time_limits(const LimitRun& run);

}  // namespace struna::apps
