#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// A clamped wire shaken by noise up to 300 Hz, stepped by Newmark's scheme; over the steps in a period at
/// 300 Hz, the damping ratio there, and the duration. Error: force at the far support, rms over rms, against
/// the modal method at a tolerance of 1e-6.
LimitMap newmark_limits(const LimitRun& run);

}  // namespace struna::apps
