#include "apps/sizing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/usage.hpp"
#include "ident/mode_flags.hpp"

namespace struna::apps {
namespace {

constexpr double widest_resolution_hz = 0.5;
constexpr double most_lines = 20000.0;
/// Lines are drawn and fitted, not summed: between them an error of 6 % (four lines) is what resonances are
/// found with.
constexpr double tolerance_between_lines = 1.0 / (ident::coarse_lines * ident::coarse_lines);

std::string reason_text(const fem::Body& body, const fem::MeshRequest& request, const fem::MeshChoice& mesh) {
  const bool response = request.target == fem::SizingTarget::response;
  const std::string at = fmt::format("up to {:g} Hz", request.hi_hz);
  const auto damping = [&] {
    const double eta = fem::acting_loss_factor(body.material, request.damping, request.hi_hz);
    if (!response) return std::string();
    if (!(eta > 0.0)) return std::string(", undamped (judged as for a loss factor of 0.001)");
    return fmt::format(", sharpened by resonances of loss factor {:.3g} (2/eta)", eta);
  };
  switch (mesh.reason) {
    case fem::MeshReason::given:
      return "the scene's own";
    case fem::MeshReason::bending:
      return fmt::format("bending waves {}, (b h)^4/1440 of a frequency{}", at, damping());
    case fem::MeshReason::stretch:
      return fmt::format("stretch and torsion waves {}, (k h)^2/24 of a frequency{}", at, damping());
    case fem::MeshReason::turn:
      return "the curve: no element turns by more than 45 degrees (10 with contact)";
    case fem::MeshReason::least:
      return "the least: the band asks for fewer";
    case fem::MeshReason::limit:
      return "the tolerance is out of reach: finer meshes lose more to rounding than they gain";
    case fem::MeshReason::checked:
      return "a check on twice the elements asked for more than the estimate";
  }
  return "";
}

Level mesh_level(const fem::Body& body, const fem::MeshRequest& request, int present, int elements) {
  return {fmt::format("{}", elements), fem::estimate_mesh_error(body, request, elements).total(),
          static_cast<double>(elements) / present};
}

std::string levels_text(const char* name, const std::vector<Level>& levels) {
  std::string text;
  for (const Level& level : levels) {
    const std::string error = std::isfinite(level.error) ? fmt::format("error {:.1e}", level.error)
                                                         : std::string("does not converge");
    const std::string cost = level.cost > 0.0 ? fmt::format(", cost {:.2g}", level.cost) : "";
    text += fmt::format("{}{}: {}, {}{}", text.empty() ? "" : "; ", name, level.value, error, cost);
  }
  return text;
}

}  // namespace

double tolerance_of(const fem::Scene& scene, double usual) {
  return scene.tolerance > 0.0 ? scene.tolerance : usual;
}

fem::MeshRequest frequency_request(const fem::Scene& scene, double highest_hz) {
  return {.hi_hz = highest_hz, .tolerance = tolerance_of(scene, frequency_tolerance)};
}

void state_tolerance(fem::Scene& scene, std::optional<double> tolerance) {
  if (!tolerance) return;
  if (!(*tolerance > 0.0 && *tolerance < 1.0)) {
    throw UsageError(fmt::format("--tolerance: must lie between 0 and 1, got {:g}", *tolerance));
  }
  scene.tolerance = *tolerance;
  if (scene.simulation) scene.simulation->tolerance = *tolerance;
}

Choice mesh_choice(const fem::Body& body, const fem::MeshRequest& request, const fem::MeshChoice& mesh) {
  Choice choice{.what = fmt::format("elements of '{}'", body.name),
                .value = fmt::format("{}", mesh.elements),
                .fixed = mesh.reason == fem::MeshReason::given,
                .why = reason_text(body, request, mesh),
                .error = mesh.error.total(),
                .tolerance = mesh.tolerance};
  choice.less = {mesh_level(body, request, mesh.elements, std::max(1, mesh.elements / 2))};
  choice.more = {mesh_level(body, request, mesh.elements, 2 * mesh.elements)};
  return choice;
}

Choice beam_theory_choice(const fem::Body& body, double f_hz) {
  const double diameter = std::sqrt(4.0 * body.section.area / std::numbers::pi);
  const double slenderness = body.centreline.length() / diameter;
  Choice choice{
      .what = fmt::format("beam theory for '{}'", body.name),
      .value = "Euler-Bernoulli",
      .why = fmt::format("length {:.3g} times the diameter; shear and rotary inertia, left out, would lower "
                         "frequencies by this at {:g} Hz",
                         slenderness, f_hz),
      .error = fem::beam_theory_error(body, f_hz),
      .tolerance = fem::largest_shear_error};
  return choice;
}

Choice lines_choice(const fem::Body& body, fem::Damping damping, double lo_hz, double hi_hz,
                    double resolution_hz, bool fixed) {
  Choice choice{
      .what = "lines", .value = fmt::format("every {:g} Hz", resolution_hz), .fixed = fixed, .why = ""};
  const double width = fem::narrowest_bandwidth_hz(body, damping, lo_hz, hi_hz);
  if (!(width > 0.0)) {
    choice.why = "no damped resonance in the band asks for more";
    return choice;
  }
  const auto error = [&](double spacing) { return std::min(1.0, spacing * spacing / (width * width)); };
  choice.why = fmt::format(
      "{:.3g} lines in the narrowest resonance, {:.3g} Hz wide; read along straight lines between",
      width / resolution_hz, width);
  choice.error = error(resolution_hz);
  choice.tolerance = tolerance_between_lines;
  choice.less = {{fmt::format("{:g} Hz", 2.0 * resolution_hz), error(2.0 * resolution_hz), 0.5}};
  choice.more = {{fmt::format("{:g} Hz", 0.5 * resolution_hz), error(0.5 * resolution_hz), 2.0}};
  return choice;
}

double default_resolution_hz(const fem::Body& body, fem::Damping damping, double lo_hz, double hi_hz) {
  const double width = fem::narrowest_bandwidth_hz(body, damping, lo_hz, hi_hz);
  if (!(width > 0.0)) return widest_resolution_hz;
  const double wanted = std::max(width / ident::coarse_lines, (hi_hz - lo_hz) / most_lines);
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  const double step = wanted >= 5.0 * decade ? 5.0 : wanted >= 2.0 * decade ? 2.0 : 1.0;
  return std::min(widest_resolution_hz, step * decade);
}

std::string explanation(const std::string& task, const std::vector<Choice>& choices) {
  std::string text = task + "\n";
  for (const Choice& choice : choices) {
    text += fmt::format("{}: {} ({})", choice.what, choice.value, choice.fixed ? "fixed" : "chosen");
    if (choice.error) text += fmt::format(", error {:.1e}", *choice.error);
    if (choice.error && choice.tolerance && !(*choice.error <= *choice.tolerance))
      text += fmt::format(", OUTSIDE the tolerance of {:g}", *choice.tolerance);
    text += "\n  why: " + choice.why + "\n";
    const std::string less = levels_text("less", choice.less), more = levels_text("more", choice.more);
    if (!less.empty() || !more.empty())
      text += "  " + less + (less.empty() || more.empty() ? "" : "; ") + more + "\n";
  }
  return text;
}

}  // namespace struna::apps
