#pragma once

#include <string>
#include <vector>

#include "fem/scene.hpp"
#include "ident/parameter_identification.hpp"

namespace struna::apps {

/// Reads scene TOML. Every fault (unknown key, missing key, wrong type, contradictory keys, value out of range) is an Error
/// with file and line; paths inside are relative to the scene file.
fem::Scene read_scene(const std::string& file);

/// Puts identified parameters into the body that they belong to, and into no other. Throws Error when the scene has no such body.
void apply_parameters(fem::Scene& scene, const std::vector<std::string>& parameter_files);

}  // namespace struna::apps
