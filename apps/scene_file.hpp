#pragma once

#include <string>
#include <vector>

#include "fem/scene.hpp"

namespace struna::apps {

/// A line told of a scene that is no warning: how far a centreline through points can be trusted.
struct Notice {
  std::string text;
  bool matters = false;  ///< told by every command, not by `eigen` alone
};

/// Reads scene TOML (docs/files.md). Every fault (unknown key, missing key, wrong type, contradictory keys,
/// value out of range) is an Error with file and line; paths inside are relative to the scene file. Warns of
/// what is probably in another unit (scene_warnings.hpp), and prints the notices that matter.
///
/// A body's Young's modulus may be missing, as it is until it has been identified: its law then has no
/// parameters. Commands that need it call require_modulus.
fem::Scene read_scene(const std::string& file);

/// The same with the scene's notices, none of them printed.
struct ToldScene {
  fem::Scene scene;
  std::vector<Notice> told;
};
ToldScene read_told_scene(const std::string& file);

/// Puts identified parameters into the body that they belong to, and into no other. Throws Error when the
/// scene has no such body, or two files speak of the same one.
void apply_parameters(fem::Scene& scene, const std::vector<std::string>& parameter_files);

/// Whether the body's Young's modulus is known.
bool has_modulus(const fem::Body& body);

/// Throws Error naming the scene's file and the body unless the body's Young's modulus is known.
void require_modulus(const fem::Body& body, const std::string& scene_file);

}  // namespace struna::apps
