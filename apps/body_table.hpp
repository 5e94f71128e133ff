#pragma once

#include <string>
#include <vector>

#include "apps/scene_file.hpp"
#include "apps/toml_table.hpp"
#include "fem/scene.hpp"

namespace struna::apps {

/// A [[body]] of a scene, its name not yet taken by the scene's other bodies. `acts_in_time`: the scene is
/// simulated, so that one of two dampings must be chosen. What is told of it that is no warning is added to
/// `told`. Throws Error with file and line.
fem::Body read_body(TomlTable& table, const fem::Scene& scene, bool acts_in_time, std::vector<Notice>& told);

}  // namespace struna::apps
