#include "apps/scene_fit.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/predict.hpp"
#include "apps/scene_file.hpp"
#include "fem/error.hpp"

namespace struna::apps {
namespace {

/// To begin with while no modulus is known: right for some 15 modes per plane.
constexpr int first_elements = 30;
constexpr int most_rounds = 5;

}  // namespace

SceneFit fit_to_scene(const fem::Scene& scene, const ident::ModeSet& modes,
                      const ident::FitOptions& options) {
  if (modes.modes.empty()) throw Error("fit: at least one mode is needed, got none");
  SceneFit fit;
  fit.scene = scene;
  if (!modes.outputs.empty()) fem::select_outputs(fit.scene, modes.outputs);
  const fem::LinearPath path = fem::linear_path(fit.scene);
  const double highest_hz = modes.modes.back().natural_frequency_hz;
  const auto elements = [&](const fem::Body& body) {
    return body.elements > 0 || has_modulus(body) ? mesh_elements(body, highest_hz) : first_elements;
  };

  fit.elements = elements(path.body);
  fem::Body& body = *std::find_if(fit.scene.bodies.begin(), fit.scene.bodies.end(),
                                  [&](const fem::Body& other) { return other.name == path.body.name; });
  for (int round = 0; round < most_rounds; ++round) {
    const fem::Model model = fem::assemble(path.body, fit.elements);
    fit.identified = ident::identify_parameters(modes, model, path.drive, path.measurement, options);
    body.material = ident::apply(fit.identified, path.body.material);
    const bool fine_enough = elements(body) <= fit.elements;
    if (fine_enough || round + 1 == most_rounds) {
      fit.doubts =
          ident::identification_doubts(modes, model, path.drive, path.measurement, options, fit.identified);
    }
    if (fine_enough) break;
    fit.elements = elements(body);
  }
  if (ident::shapes_disagree_grossly(fit.doubts)) ident::withdraw_trust(fit.identified);
  return fit;
}

std::string trust_line(const ident::ModeSet& modes, const ident::IdentifiedParameters& identified) {
  return fmt::format("{} modes, {} trusted for the modulus, {} for the damping", modes.modes.size(),
                     identified.modulus.value.size(), identified.loss_factor.value.size());
}

std::string rayleigh_line(const ident::IdentifiedParameters& identified) {
  if (!identified.rayleigh_known) return "Rayleigh: no mode is trusted for its damping";
  const ident::RayleighFit& fit = identified.rayleigh;
  std::string line =
      fmt::format("Rayleigh: alpha = {:.4g} +- {:.2g} 1/s{}, beta = {:.4g} +- {:.2g} s{}, rms/sigma {:.2f}",
                  fit.rayleigh.alpha, fit.alpha_sigma, fit.alpha_at_bound ? " (held at zero)" : "",
                  fit.rayleigh.beta, fit.beta_sigma, fit.beta_at_bound ? " (held at zero)" : "", fit.rms);
  return fit.determined ? line : line + "; one frequency: beta alone";
}

}  // namespace struna::apps
