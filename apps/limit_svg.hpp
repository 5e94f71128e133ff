#pragma once

#include <string>

#include "apps/limit_map.hpp"

namespace struna::apps {

/// The map as a picture: a cell for each place, split by the shares of its trials (right; right but flagged;
/// wrong and flagged; wrong without a flag; refused), one panel for each value of the third axis, the key
/// and the sentence below.
std::string limit_svg(const LimitMap& map);

}  // namespace struna::apps
