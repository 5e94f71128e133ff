#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Modes of a curved wire, of which some are missing and some are none, paired with a model of another
/// modulus: missing x spurious x modulus. A trial is a pair, right where the model mode is the measured
/// one's; flagged where it is rejected, or its list carries a doubt about which modes were paired.
LimitMap pairing_limits(const LimitRun& run);

}  // namespace struna::apps
