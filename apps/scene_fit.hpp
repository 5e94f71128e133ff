#pragma once

#include <string>
#include <vector>

#include "apps/sizing.hpp"
#include "fem/scene.hpp"
#include "fem/sizing.hpp"
#include "ident/doubts.hpp"
#include "ident/parameter_identification.hpp"

namespace struna::apps {

struct SceneFit {
  ident::IdentifiedParameters identified;
  fem::Scene scene;          ///< with what was identified in the body that it belongs to
  int elements = 0;          ///< of the mesh that it was identified with
  fem::MeshRequest request;  ///< for the modulus found; its highest frequency is that of the highest mode
  std::vector<ident::Doubt> doubts;
};

/// Identifies the parameters of the scene's driven and measured body from measured modes. The scene's outputs
/// are brought into the order of the modes' own. Where the scene leaves the number of elements open, the mesh
/// follows from the modulus that is found: fitted again on a finer one until it keeps the scene's tolerance
/// up to the highest mode, and until the modulus at which elastic supports are told is the one found. Where
/// the modes' shapes disagree grossly with the model's, none of them is trusted. Throws Error when there are
/// no modes, or the scene lacks one of their outputs.
SceneFit fit_to_scene(const fem::Scene& scene, const ident::ModeSet& modes, const ident::FitOptions& options);

/// The mesh as --explain tells it, once the modulus is known.
std::vector<Choice> fit_choices(const SceneFit& fit);

/// "14 modes, 14 trusted for the modulus, 12 for the damping".
std::string trust_line(const ident::ModeSet& modes, const ident::IdentifiedParameters& identified);

/// The numbers of the body that were fitted beside the modulus, a line each.
std::vector<std::string> fitted_lines(const ident::IdentifiedParameters& identified);

/// Those that were to be fitted and are not told by the modes, with the reason, a line each.
std::vector<std::string> inseparable_lines(const ident::IdentifiedParameters& identified);

/// What the sigmas of the scene put on the modulus, in one line; "" without any.
std::string scene_error_line(const ident::IdentifiedParameters& identified);

/// The Rayleigh coefficients with their standard errors, in one line.
std::string rayleigh_line(const ident::IdentifiedParameters& identified);

}  // namespace struna::apps
