#include "apps/scene_fit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/scene_file.hpp"
#include "fem/error.hpp"
#include "ident/rayleigh_flag.hpp"

namespace struna::apps {
namespace {

/// To begin with while no modulus is known: right for some 15 modes per plane.
constexpr int first_elements = 30;
constexpr int most_rounds = 8;

/// Whether the modulus at which springs are told is the same.
bool same_reference(const fem::Body& a, const fem::Body& b) {
  const auto modulus = [](const fem::Body& body) {
    return body.material.youngs_modulus.at(fem::support_reference_hz);
  };
  return std::abs(modulus(a) / modulus(b) - 1.0) < 1e-7;
}

}  // namespace

SceneFit fit_to_scene(const fem::Scene& scene, const ident::ModeSet& modes,
                      const ident::FitOptions& options) {
  if (modes.modes.empty()) throw Error("fit: at least one mode is needed, got none");
  SceneFit fit;
  fit.scene = scene;
  if (!modes.outputs.empty()) fem::select_outputs(fit.scene, modes.outputs);
  fem::LinearPath path = fem::linear_path(fit.scene);
  const double highest_hz = modes.modes.back().natural_frequency_hz;
  fit.request = frequency_request(scene, highest_hz);
  const auto elements = [&](const fem::Body& body) {
    if (body.elements > 0) return body.elements;
    return has_modulus(body) ? fem::choose_mesh(body, fit.request).elements : first_elements;
  };

  fit.elements = elements(path.body);
  const auto identify = [&](const fem::Body& body, const ident::FitOptions& with) {
    return ident::identify_parameters(modes, fem::assemble(body, fit.elements), path.drive, path.measurement,
                                      with);
  };
  const bool elastic = fem::has_elastic_support(path.body);
  if (elastic && !has_modulus(path.body)) {
    // Springs are told at the body's modulus: one to begin with, from rigid supports.
    fem::Body rigid = path.body;
    rigid.start_support = rigid.end_support = {};
    ident::FitOptions material_alone = options;
    material_alone.free.clear();
    path.body.material = ident::apply(identify(rigid, material_alone), path.body.material);
  }
  fem::Body& body = *std::find_if(fit.scene.bodies.begin(), fit.scene.bodies.end(),
                                  [&](const fem::Body& other) { return other.name == path.body.name; });
  for (int round = 0; round < most_rounds; ++round) {
    fit.identified = identify(path.body, options);
    body = ident::apply(fit.identified, path.body);
    const bool fine_enough = elements(body) <= fit.elements;
    const bool settled = fine_enough && (!elastic || same_reference(body, path.body));
    if (settled || round + 1 == most_rounds) {
      fit.doubts = ident::identification_doubts(modes, fem::assemble(body, fit.elements), path.drive,
                                                path.measurement, options, fit.identified);
    }
    if (settled) break;
    if (elastic) path.body.material = body.material;
    fit.elements = std::max(fit.elements, elements(body));
  }
  if (ident::shapes_disagree_grossly(fit.doubts)) ident::withdraw_trust(fit.identified);
  return fit;
}

std::vector<Choice> fit_choices(const SceneFit& fit) {
  fem::Body body = fem::linear_path(fit.scene).body;
  if (!has_modulus(body)) return {};
  const bool given = body.elements > 0;
  fem::MeshChoice mesh = fem::choose_mesh(body, fit.request);
  if (!given && mesh.elements != fit.elements) {  // begun with more, or ended with fewer rounds
    mesh.elements = fit.elements;
    mesh.error = fem::estimate_mesh_error(body, fit.request, fit.elements);
  }
  Choice choice = mesh_choice(body, fit.request, mesh);
  if (!given && fit.elements == first_elements)
    choice.why = "enough to begin with, before a modulus is known";
  return {choice, beam_theory_choice(body, fit.request.hi_hz)};
}

std::string trust_line(const ident::ModeSet& modes, const ident::IdentifiedParameters& identified) {
  return fmt::format("{} modes, {} trusted for the modulus, {} for the damping", modes.modes.size(),
                     identified.modulus.value.size(), identified.loss_factor.value.size());
}

std::vector<std::string> fitted_lines(const ident::IdentifiedParameters& identified) {
  std::vector<std::string> lines;
  const ident::FittedNumbers& fitted = identified.fitted;
  const auto unit = [](const std::string& name) {
    return name == "torsion_constant"       ? "m^4"
           : name.ends_with(".rotation")    ? "N m/rad"
           : name.ends_with(".translation") ? "N/m"
                                            : "kg";
  };
  for (std::size_t k = 0; k < fitted.name.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    lines.push_back(fmt::format(
        "{} = {:.5g} +- {:.2g} {}, fitted beside the modulus; condition number {:.3g}", fitted.name[k],
        fitted.value[at], fitted.sigma()[at], unit(fitted.name[k]), fitted.condition));
  }
  return lines;
}

std::vector<std::string> inseparable_lines(const ident::IdentifiedParameters& identified) {
  std::vector<std::string> lines;
  for (const auto& left : identified.fitted.inseparable)
    lines.push_back(
        fmt::format("{} is not fitted, and left as the scene has it: {}", left.name, left.reason));
  return lines;
}

std::string scene_error_line(const ident::IdentifiedParameters& identified) {
  std::vector<std::string> parts;
  double variance = 0.0;
  for (const ident::BodyErrorStep& step : identified.errors) {
    if (step.is_fitted()) continue;
    variance += step.level * step.level;
    parts.push_back(fmt::format("{} {:.2g} %", step.of, 100.0 * std::abs(step.level)));
  }
  if (parts.empty()) return "";
  return fmt::format(
      "scene: its stated errors put {:.2g} % on the modulus of all modes alike, besides the noise ({})",
      100.0 * std::sqrt(variance), fmt::join(parts, ", "));
}

std::string rayleigh_line(const ident::IdentifiedParameters& identified) {
  if (!identified.rayleigh_known) return "Rayleigh: no mode is trusted for its damping";
  const ident::RayleighFit& fit = identified.rayleigh;
  std::string line =
      fmt::format("Rayleigh: alpha = {:.4g} +- {:.2g} 1/s{}, beta = {:.4g} +- {:.2g} s{}, rms/sigma {:.2f}",
                  fit.rayleigh.alpha, fit.alpha_sigma, fit.alpha_at_bound ? " (held at zero)" : "",
                  fit.rayleigh.beta, fit.beta_sigma, fit.beta_at_bound ? " (held at zero)" : "", fit.rms);
  if (const std::string caveat = ident::caveat(fit); !caveat.empty()) line += "; " + caveat;
  return line;
}

}  // namespace struna::apps
