#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/predict.hpp"
#include "apps/scene_file.hpp"
#include "fem/eigenmodes.hpp"
#include "ident/atomic_file.hpp"

namespace struna::apps {
namespace {

constexpr int default_modes = 12;
constexpr int most_modes = 1000;

struct EigenArguments {
  std::string scene;
  std::vector<std::string> parameters;
  std::string body;
  std::string band;
  std::string to;
  int modes = 0;
};

struct EigenResult {
  Eigen::VectorXd frequency_hz;
  Eigen::VectorXd mesh_error;  ///< estimated, relative; the mesh's frequencies are too high by it
  std::vector<std::string> output;
  Eigen::MatrixXd constant;  ///< modes x outputs; no columns where the body is not driven and measured
  std::string constant_unit;
  int elements = 0;
};

/// The body named, or the one that is driven and measured, or the only one.
fem::Body chosen_body(const fem::Scene& scene, const std::string& name) {
  if (!name.empty()) return fem::body_named(scene, name);
  if (scene.drive && scene.measurement) return fem::linear_path(scene).body;
  if (scene.bodies.size() == 1) return scene.bodies.front();
  throw Error("the scene has several bodies and no driven and measured one: choose one with --body");
}

/// Upper estimate of the natural frequency that `modes` modes reach: those of a straight body come in pairs.
double highest_frequency_hz(const fem::Body& body, int modes) {
  const double ratio = (0.5 * modes + 1.5) * std::numbers::pi / 4.730040744862704;
  return fem::natural_frequency_hz(fem::clamped_eigenvalue(body) * std::pow(ratio, 4),
                                   body.material.youngs_modulus);
}

Eigen::VectorXd frequencies(const fem::Eigenmodes& modes, const fem::FrequencyLaw& modulus) {
  return modes.eigenvalue.unaryExpr(
      [&](double lambda) { return fem::natural_frequency_hz(lambda, modulus); });
}

/// Modes wanted for a band: doubled until the highest one lies above it.
int modes_below(const fem::Model& model, const fem::FrequencyLaw& modulus, double hi_hz) {
  const int all = static_cast<int>(model.free_dof.size());
  for (int count = default_modes;; count = std::min(2 * count, all)) {
    const Eigen::VectorXd f = frequencies(fem::solve_eigenmodes(model, count), modulus);
    const int below = static_cast<int>((f.array() <= hi_hz).count());
    if (below < count || count == all) return below;
  }
}

std::string unit_of_constant(const fem::LinearPath& path) {
  const bool force_in = std::holds_alternative<fem::PointForce>(path.drive);
  const bool force_out = std::holds_alternative<fem::SupportForce>(path.measurement.what);
  return force_in == force_out ? "1/s^2" : force_out ? "kg/s^2" : "1/kg";
}

EigenResult solve(const fem::Scene& scene, const fem::Body& body, const EigenArguments& arguments) {
  const fem::FrequencyLaw& modulus = body.material.youngs_modulus;
  const Band band = arguments.band.empty() ? Band{} : parse_band(arguments.band);
  int count = arguments.modes > 0 ? arguments.modes : default_modes;
  EigenResult result;
  result.elements =
      mesh_elements(body, arguments.band.empty() ? highest_frequency_hz(body, count) : band.hi_hz);
  const fem::Model model = fem::assemble(body, result.elements);
  if (!arguments.band.empty()) count = modes_below(model, modulus, band.hi_hz);
  count = std::min(count, static_cast<int>(model.free_dof.size()));
  if (count == 0) {
    throw Error(fmt::format("body '{}' has no natural frequency below {:g} Hz", body.name, band.hi_hz));
  }
  const fem::Eigenmodes modes = fem::solve_eigenmodes(model, count);
  result.frequency_hz = frequencies(modes, modulus);
  const Eigen::VectorXd finer =
      frequencies(fem::solve_eigenmodes(fem::assemble(body, 2 * result.elements), count), modulus);
  // Errors fall as h^4. A rigid motion, at zero, has none.
  result.mesh_error = (finer.array() > 1e-3 * result.frequency_hz(count - 1) / count)
                          .select(16.0 / 15.0 * (result.frequency_hz.array() / finer.array() - 1.0), 0.0);
  if (scene.drive && scene.measurement && fem::linear_path(scene).body.name == body.name) {
    const fem::LinearPath path = fem::linear_path(scene);
    result.output = scene.measurement->names;
    result.constant = fem::modal_constants(model, modes, path.drive, path.measurement, modulus);
    result.constant_unit = unit_of_constant(path);
  }
  return result;
}

bool wanted(const EigenResult& result, long r, const EigenArguments& arguments) {
  return arguments.band.empty() || result.frequency_hz(r) >= parse_band(arguments.band).lo_hz;
}

std::string csv(const EigenResult& result, const fem::Body& body, const EigenArguments& arguments) {
  std::string text = "mode,natural_frequency [Hz],mesh_error [-],youngs_modulus [Pa]";
  for (const std::string& name : result.output)
    text += fmt::format(",{}_modal_constant [{}]", name, result.constant_unit);
  text += '\n';
  for (long r = 0; r < result.frequency_hz.size(); ++r) {
    if (!wanted(result, r, arguments)) continue;
    const double f = result.frequency_hz(r);
    text += fmt::format("{},{:.12g},{:.3g},{:.12g}", r + 1, f, result.mesh_error(r),
                        f > 0.0 ? body.material.youngs_modulus.at(f) : 0.0);
    for (long k = 0; k < result.constant.cols(); ++k) text += fmt::format(",{:.12g}", result.constant(r, k));
    text += '\n';
  }
  return text;
}

Table table(const EigenResult& result, const fem::Body& body, const EigenArguments& arguments) {
  Table shown{{"mode", "natural frequency [Hz]", "mesh error", "E [GPa]"}, {}};
  for (const std::string& name : result.output)
    shown.header.push_back(fmt::format("C {} [{}]", name, result.constant_unit));
  for (long r = 0; r < result.frequency_hz.size(); ++r) {
    if (!wanted(result, r, arguments)) continue;
    const double f = result.frequency_hz(r);
    std::vector<std::string> row = {
        fmt::format("{}", r + 1), fmt::format("{:.6f}", f), fmt::format("{:.1e}", result.mesh_error(r)),
        f > 0.0 ? fmt::format("{:.4f}", 1e-9 * body.material.youngs_modulus.at(f)) : "-"};
    for (long k = 0; k < result.constant.cols(); ++k)
      row.push_back(fmt::format("{:.4g}", result.constant(r, k)));
    shown.rows.push_back(std::move(row));
  }
  return shown;
}

void run_eigen(const EigenArguments& arguments) {
  if (arguments.modes > 0 && !arguments.band.empty())
    throw UsageError("--modes, --band: give one of the two");
  fem::Scene scene = read_scene(arguments.scene);
  apply_parameters(scene, arguments.parameters);
  const fem::Body body = blaming({arguments.scene}, [&] { return chosen_body(scene, arguments.body); });
  require_modulus(body, arguments.scene);
  const EigenResult result = blaming({arguments.scene}, [&] { return solve(scene, body, arguments); });
  for (const std::string& warning :
       extrapolation_warnings(body, fem::Damping::viscous, result.frequency_hz)) {
    warn(warning);
  }
  if (!arguments.to.empty()) ident::write_atomically(arguments.to, csv(result, body, arguments));
  print(fmt::format("body {}, {} elements", body.name, result.elements));
  print(table(result, body, arguments));
}

}  // namespace

void add_eigen(CLI::App& app) {
  const auto arguments = std::make_shared<EigenArguments>();
  CLI::App* const eigen =
      app.add_subcommand("eigen", "natural frequencies and modal constants of a body of the scene");
  eigen->add_option("SCENE", arguments->scene, "scene TOML")->required();
  eigen->add_option("--parameters", arguments->parameters, "identified.toml, one per body")
      ->allow_extra_args(false);
  eigen->add_option("--body", arguments->body, "body; default: the one driven and measured, or the only one");
  eigen->add_option("--modes", arguments->modes, "number of modes; default 12")
      ->check(CLI::Range(1, most_modes));
  eigen->add_option("--band", arguments->band, "LO:HI [Hz]: the modes in it");
  eigen->add_option("-o", arguments->to, "CSV to write");
  eigen->footer(
      "Example:\n"
      "  struna eigen scene.toml --parameters identified.toml --band 10:1000 -o eigen.csv\n"
      "  struna eigen scene.toml --body band --modes 6");
  eigen->callback([arguments] { run_eigen(*arguments); });
}

}  // namespace struna::apps
