#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Modes of a curved wire, of which some are missing and some are none, paired with a model of another
/// modulus: missing x spurious x modulus. Right where every pair is true.
LimitMap pairing_limits(const LimitRun& run);

}  // namespace struna::apps
