#pragma once

#include <string>
#include <vector>

#include "fem/scene.hpp"

namespace struna::apps {

/// Numbers of a scene that are possible but mostly mean another unit (millimetres, GPa, g/cm^3), or a body
/// too thick for beam theory; a line each, naming body, value and what is probably meant.
std::vector<std::string> scene_warnings(const fem::Scene& scene);

}  // namespace struna::apps
