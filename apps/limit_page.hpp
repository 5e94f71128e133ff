#pragma once

#include <string>
#include <vector>

#include "apps/limit_map.hpp"

namespace struna::apps {

/// index.html, self-contained. `command` is how to make it again.
std::string limit_page(const std::vector<LimitMap>& maps, const std::string& command);

}  // namespace struna::apps
