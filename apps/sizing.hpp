#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fem/scene.hpp"
#include "fem/sizing.hpp"

namespace struna::apps {

/// Natural frequencies of a mesh that the program chooses are within this, relative, unless a tolerance is
/// stated.
inline constexpr double frequency_tolerance = 1e-5;
/// Outputs of a prediction likewise, relative to all outputs on the worst line.
inline constexpr double response_tolerance = 1e-3;

/// The scene's tolerance, or `usual` where it states none.
double tolerance_of(const fem::Scene& scene, double usual);

/// --tolerance, when given, in place of the scene's own, that of its [simulation] too. Throws
/// UsageError unless between 0 and 1.
void state_tolerance(fem::Scene& scene, std::optional<double> tolerance);

/// The mesh for natural frequencies up to highest_hz, to the scene's tolerance.
fem::MeshRequest frequency_request(const fem::Scene& scene, double highest_hz);

/// What another setting would give.
struct Level {
  std::string value;
  double error = 0.0;
  double cost = 0.0;  ///< over that of the present setting
};

/// One decision about the model, for --explain.
struct Choice {
  std::string what;
  std::string value;
  bool fixed = false;  ///< by the user
  std::string why;
  std::optional<double> error = {};      ///< estimated
  std::optional<double> tolerance = {};  ///< that the error is held against
  std::vector<Level> less = {};
  std::vector<Level> more = {};
};

/// The mesh of a body, with half and twice the elements beside it.
Choice mesh_choice(const fem::Body& body, const fem::MeshRequest& request, const fem::MeshChoice& mesh);

/// Whether beam theory holds up to f_hz: slenderness, and what shear and rotary inertia would take off.
Choice beam_theory_choice(const fem::Body& body, double f_hz);

/// Lines every `resolution_hz`: read along straight lines between them, a resonance of bandwidth w is off by
/// (resolution/w)^2 of its peak.
Choice lines_choice(const fem::Body& body, fem::Damping damping, double lo_hz, double hi_hz,
                    double resolution_hz, bool fixed);

/// The line spacing that puts as many lines into the narrowest resonance as `struna modes` needs
/// (ident::coarse_lines), from 1, 2 or 5 times a power of ten; at most 0.5 Hz, at most 20000 lines.
double default_resolution_hz(const fem::Body& body, fem::Damping damping, double lo_hz, double hi_hz);

/// The text that --explain prints: `task` and the choices, two to four lines each.
std::string explanation(const std::string& task, const std::vector<Choice>& choices);

}  // namespace struna::apps
