#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/predict.hpp"
#include "apps/scene_file.hpp"
#include "apps/sizing.hpp"
#include "fem/plane_modes.hpp"
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
  std::optional<double> tolerance;
  bool explain = false;
};

/// What was asked for: a band, or the lowest modes; 0: as many as is usual.
struct Wanted {
  int modes = 0;
  std::optional<Band> band;
};

struct EigenResult {
  long first = 0;  ///< modes below the first one listed
  Eigen::VectorXd frequency_hz;
  Eigen::VectorXd mesh_error;  ///< estimated, relative; the mesh's frequencies are too high by it
  std::vector<std::string> output;
  Eigen::MatrixXd constant;  ///< modes x outputs; no columns where the body is not driven and measured
  std::string constant_unit;
  int elements = 0;
  fem::MeshRequest request;
  fem::MeshChoice mesh;
};

/// The body named, or the one that is driven and measured, or the only one.
fem::Body chosen_body(const fem::Scene& scene, const std::string& name) {
  if (!name.empty()) return fem::body_named(scene, name);
  for (const fem::Body& body : scene.bodies) {
    if (fem::is_on_linear_path(scene, body.name)) return body;
  }
  if (scene.bodies.size() == 1) return scene.bodies.front();
  throw Error("the scene has several bodies and none that is both driven and measured: choose with --body");
}

/// Upper estimate of the natural frequency that `modes` modes reach: those of a straight body come in pairs.
double highest_frequency_hz(const fem::Body& body, int modes) {
  const double ratio = (0.5 * modes + 1.5) * std::numbers::pi / 4.730040744862704;
  return fem::natural_frequency_hz(fem::clamped_eigenvalue(body) * std::pow(ratio, 4),
                                   body.material.youngs_modulus);
}

/// The lowest modes, those of a straight body in the plane of the drive and across it, for constants that
/// mean something.
fem::Eigenmodes solve_modes(const fem::Scene& scene, const fem::Model& model, int count) {
  const Eigen::Vector3d direction = scene.drive ? scene.drive->direction : Eigen::Vector3d::UnitY();
  return fem::solve_plane_modes(model, direction, count);
}

/// Modes up to `hi_hz`: twice as many until the highest one lies above it.
int modes_below(const fem::Model& model, double hi_hz) {
  const int all = static_cast<int>(model.free_dof.size());
  for (int count = std::min(default_modes, all);; count = std::min(2 * count, all)) {
    const Eigen::VectorXd f =
        fem::natural_frequencies_hz(model.body, fem::solve_eigenmodes(model, count).eigenvalue);
    const int below = static_cast<int>((f.array() <= hi_hz).count());
    if (below < count) return below;
    if (count == all) {
      throw Error(
          fmt::format("the {} elements of body '{}' end at mode {}, {:.6g} Hz, below the band's end, {:g} "
                      "Hz; more elements "
                      "in the scene reach higher",
                      model.arc_length.size() - 1, model.body.name, all, f(all - 1), hi_hz));
    }
  }
}

/// How many modes to solve for.
int count_of(const Wanted& wanted, const fem::Model& model) {
  const int all = static_cast<int>(model.free_dof.size());
  if (wanted.band) return std::min(modes_below(model, wanted.band->hi_hz) + 1, all);
  if (wanted.modes > all) {
    throw Error(
        fmt::format("--modes {}: the {} elements of body '{}' have {} modes; more elements in the scene",
                    wanted.modes, model.arc_length.size() - 1, model.body.name, all));
  }
  return wanted.modes > 0 ? wanted.modes : std::min(default_modes, all);
}

/// The range of modes to list: all, or those in the band, the modes beside which are told when it is empty.
std::pair<long, long> listed_modes(const Wanted& wanted, const Eigen::VectorXd& frequency_hz,
                                   const std::string& body) {
  if (!wanted.band) return {0, frequency_hz.size()};
  const Band& band = *wanted.band;
  const long first = (frequency_hz.array() < band.lo_hz).count();
  const long end = (frequency_hz.array() <= band.hi_hz).count();
  if (first < end) return {first, end};
  const std::string below =
      first > 0 ? fmt::format("mode {} at {:.6g} Hz, ", first, frequency_hz(first - 1)) : "";
  throw Error(
      fmt::format("body '{}' has no natural frequency from {:g} to {:g} Hz; next to it: {}mode "
                  "{} at {:.6g} Hz",
                  body, band.lo_hz, band.hi_hz, below, end + 1, frequency_hz(end)));
}

std::string unit_of_constant(const fem::LinearPath& path) {
  const bool force_in = std::holds_alternative<fem::PointForce>(path.drive);
  const bool force_out = std::holds_alternative<fem::SupportForce>(path.measurement.what);
  return force_in == force_out ? "1/s^2" : force_out ? "kg/s^2" : "1/kg";
}

/// Estimated from a mesh of twice the elements: errors fall as h^4. A rigid motion has none.
Eigen::VectorXd mesh_error(const fem::Body& body, int elements, const Eigen::VectorXd& frequency_hz) {
  const fem::Model finer = fem::assemble(body, 2 * elements);
  const Eigen::VectorXd finer_hz = fem::natural_frequencies_hz(
      body, fem::solve_eigenmodes(finer, static_cast<int>(frequency_hz.size())).eigenvalue);
  return (finer_hz.array() > 0.0).select(16.0 / 15.0 * (frequency_hz.array() / finer_hz.array() - 1.0), 0.0);
}

EigenResult solve(const fem::Scene& scene, const fem::Body& body, const Wanted& wanted) {
  EigenResult result;
  const int modes_estimated = wanted.modes > 0 ? wanted.modes : default_modes;
  result.request = frequency_request(
      scene, wanted.band ? wanted.band->hi_hz : highest_frequency_hz(body, modes_estimated));
  result.mesh = fem::choose_mesh(body, result.request);
  // A count of modes must have its degrees of freedom, whatever the tolerance: two per element and plane.
  if (body.elements == 0) result.mesh.elements = std::max(result.mesh.elements, modes_estimated / 2);
  result.elements = result.mesh.elements;
  const fem::Model model = fem::assemble(body, result.elements);
  const fem::Eigenmodes modes = solve_modes(scene, model, count_of(wanted, model));
  const Eigen::VectorXd frequency_hz = fem::natural_frequencies_hz(body, modes.eigenvalue);
  const auto [first, end] = listed_modes(wanted, frequency_hz, body.name);
  result.first = first;
  result.frequency_hz = frequency_hz.segment(first, end - first);
  result.mesh_error = mesh_error(body, result.elements, frequency_hz).segment(first, end - first);
  if (fem::is_on_linear_path(scene, body.name)) {
    const fem::LinearPath path = fem::linear_path(scene);
    result.output = scene.measurement->names;
    const Eigen::MatrixXd constant =
        fem::modal_constants(model, modes, path.drive, path.measurement, body.material.youngs_modulus);
    result.constant = constant.middleRows(first, end - first).array() + 0.0;  // no "-0"
    result.constant_unit = unit_of_constant(path);
  }
  return result;
}

std::string csv(const EigenResult& result, const fem::Body& body) {
  std::string text = "mode,natural_frequency [Hz],mesh_error [-],youngs_modulus [Pa]";
  for (const std::string& name : result.output)
    text += fmt::format(",{}_modal_constant [{}]", name, result.constant_unit);
  text += '\n';
  for (long r = 0; r < result.frequency_hz.size(); ++r) {
    const double f = result.frequency_hz(r);
    text += fmt::format("{},{:.12g},{:.3g},{:.12g}", result.first + r + 1, f, result.mesh_error(r),
                        f > 0.0 ? body.material.youngs_modulus.at(f) : 0.0);
    for (long k = 0; k < result.constant.cols(); ++k) text += fmt::format(",{:.12g}", result.constant(r, k));
    text += '\n';
  }
  return text;
}

Table table(const EigenResult& result, const fem::Body& body) {
  Table shown{{"mode", "natural frequency [Hz]", "mesh error", "E [GPa]"}, {}};
  for (const std::string& name : result.output)
    shown.header.push_back(fmt::format("C {} [{}]", name, result.constant_unit));
  for (long r = 0; r < result.frequency_hz.size(); ++r) {
    const double f = result.frequency_hz(r);
    std::vector<std::string> row = {
        fmt::format("{}", result.first + r + 1), fmt::format("{:.6f}", f),
        fmt::format("{:.1e}", result.mesh_error(r)),
        f > 0.0 ? fmt::format("{:.4f}", 1e-9 * body.material.youngs_modulus.at(f)) : "-"};
    for (long k = 0; k < result.constant.cols(); ++k)
      row.push_back(fmt::format("{:.4g}", result.constant(r, k)));
    shown.rows.push_back(std::move(row));
  }
  return shown;
}

std::vector<Choice> choices(const EigenResult& result, const fem::Body& body) {
  Choice elements = mesh_choice(body, result.request, result.mesh);
  elements.why += fmt::format("; estimate before {:.1e}, found on twice the elements", *elements.error);
  elements.error = result.mesh_error.cwiseAbs().maxCoeff();
  return {elements, beam_theory_choice(body, result.frequency_hz.maxCoeff())};
}

void run_eigen(const EigenArguments& arguments) {
  Wanted wanted{arguments.modes, std::nullopt};
  if (!arguments.band.empty()) {
    if (arguments.modes > 0) throw UsageError("--modes, --band: give one of the two");
    wanted.band = parse_band(arguments.band);
  }
  ToldScene read = read_told_scene(arguments.scene);
  fem::Scene& scene = read.scene;
  apply_parameters(scene, arguments.parameters);
  state_tolerance(scene, arguments.tolerance);
  const fem::Body body = blaming({arguments.scene}, [&] { return chosen_body(scene, arguments.body); });
  require_modulus(body, arguments.scene);
  const EigenResult result = blaming({arguments.scene}, [&] { return solve(scene, body, wanted); });
  const long rigid = (result.frequency_hz.array() == 0.0).count();
  for (const std::string& warning : extrapolation_warnings(
           body, fem::Damping::viscous, result.frequency_hz.tail(result.frequency_hz.size() - rigid))) {
    warn(warning);
  }
  if (!arguments.to.empty()) ident::write_atomically(arguments.to, csv(result, body));
  print(fmt::format("body {}, {} elements", body.name, result.elements));
  print(table(result, body));
  for (const Notice& notice : read.told) print(notice.text);
  if (arguments.explain) {
    print("");
    print(explanation(fmt::format("sized for natural frequencies within {:g} up to {:g} Hz",
                                  result.request.tolerance, result.request.hi_hz),
                      choices(result, body)));
  }
}

}  // namespace

void add_eigen(CLI::App& app) {
  const auto arguments = std::make_shared<EigenArguments>();
  CLI::App* const eigen =
      app.add_subcommand("eigen", "natural frequencies and modal constants of a body of the scene");
  eigen->add_option("SCENE.toml", arguments->scene, "the scene")->type_name("")->required();
  eigen->add_option("--parameters", arguments->parameters, "identified.toml; may be repeated, one per body")
      ->type_name(read_file + std::string(".toml"))
      ->allow_extra_args(false);
  eigen->add_option("--body", arguments->body, "which; default: the one driven and measured, or the only one")
      ->type_name("NAME");
  eigen
      ->add_option("--modes", arguments->modes,
                   fmt::format("how many, 1 to {}; default {}", most_modes, default_modes))
      ->type_name("N")
      ->check(CLI::Range(1, most_modes).description(""));
  eigen->add_option("--band", arguments->band, "the modes in it [Hz]")->type_name("LO:HI");
  eigen
      ->add_option("--tolerance", arguments->tolerance,
                   "of the frequencies, relative; default: the scene's, or 1e-5")
      ->type_name("NUMBER");
  eigen->add_flag("--explain", arguments->explain,
                  "tell what mesh was chosen, why, and what more or less would give");
  eigen->add_option("-o", arguments->to, "table to write")->type_name(written_file + std::string(".csv"));
  eigen->footer(
      "Example:\n"
      "  struna eigen scene.toml --parameters identified.toml --band 10:1000 -o eigen.csv\n"
      "  struna eigen scene.toml --body band --modes 6");
  eigen->callback([arguments] { run_eigen(*arguments); });
}

}  // namespace struna::apps
