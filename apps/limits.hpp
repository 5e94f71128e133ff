#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/limit_map.hpp"

namespace struna::apps {

/// A map that can be asked for by name.
struct KnownLimit {
  std::string name;
  std::function<LimitMap(const LimitRun&)> map;
};

/// All maps, in the order of the data.
std::vector<KnownLimit> known_limits();

}  // namespace struna::apps
