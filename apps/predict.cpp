#include "apps/predict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/scene_file.hpp"
#include "apps/sizing.hpp"
#include "fem/sized_response.hpp"
#include "ident/parameter_file.hpp"
#include "ident/prediction_band.hpp"
#include "ident/rayleigh_flag.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

constexpr double default_from_hz = 10.0;
constexpr double default_to_hz = 1000.0;
/// Largest mesh error that passes without a warning.
constexpr double quiet_mesh_error = 0.01;

struct PredictArguments {
  std::string scene;
  std::vector<std::string> parameters;
  std::string to;
  std::string like;
  std::string damping = "structural";
  std::string band;
  double resolution_hz = 0.0;
  std::optional<double> tolerance;
  bool explain = false;
};

/// Order of the time derivative that is read over that of displacement; 0 where the ratio does not depend on
/// it.
int derivative(const fem::Scene& scene) {
  const bool motion_over_force = std::holds_alternative<fem::BodyPoint>(scene.drive->at) &&
                                 std::holds_alternative<fem::BodyPoint>(scene.measurement->at);
  if (!motion_over_force) return 0;
  switch (scene.measurement->quantity) {
    case fem::MotionQuantity::displacement:
      return 0;
    case fem::MotionQuantity::velocity:
      return 1;
    case fem::MotionQuantity::acceleration:
      return 2;
  }
  return 0;
}

ident::FrfKind natural_kind(const fem::Scene& scene) {
  const bool force_in = std::holds_alternative<fem::BodyPoint>(scene.drive->at);
  const bool force_out = std::holds_alternative<fem::Support>(scene.measurement->at);
  if (force_in == force_out) return ident::FrfKind::transmissibility;
  if (force_out) return ident::FrfKind::dynamic_stiffness;
  constexpr ident::FrfKind by_derivative[] = {ident::FrfKind::receptance, ident::FrfKind::mobility,
                                              ident::FrfKind::accelerance};
  return by_derivative[derivative(scene)];
}

Eigen::VectorXd uniform_lines(const Band& band, double resolution_hz) {
  const double first = std::max(band.lo_hz, resolution_hz);
  const double count = std::floor((band.hi_hz - first) / resolution_hz * (1.0 + 1e-12)) + 1.0;
  if (!(count >= 1.0 && count <= 1e7)) {
    throw UsageError(fmt::format("--resolution: {:g} Hz does not fit the band {:g} to {:g} Hz", resolution_hz,
                                 band.lo_hz, band.hi_hz));
  }
  return first + resolution_hz * Eigen::ArrayXd::LinSpaced(static_cast<long>(count), 0.0, count - 1.0);
}

/// What --like asks for: outputs (into the scene), form and lines.
struct Wanted {
  Eigen::VectorXd frequency_hz;
  ident::FrfKind form = ident::FrfKind::unknown;
  double exponential_decay = 0.0;  ///< [1/s] that the --like file's window added
  double resolution_hz = 0.0;      ///< 0: the lines are a file's
};

Wanted wanted_like(const std::string& file, const std::string& band, fem::Scene& scene) {
  std::vector<std::string> warnings;
  ident::TransferFunction like = ident::read_transfer_function(file, &warnings);
  for (const std::string& warning : warnings) warn(warning);
  if (!band.empty()) {
    const Band limits = parse_band(band);
    like = blaming({file}, [&] { return ident::restrict_band(like, limits.lo_hz, limits.hi_hz); });
  }
  std::vector<std::string> names;
  for (const auto& output : like.outputs) {
    names.push_back(output.name);
    if (output.kind != like.outputs.front().kind) {
      throw Error(file, 0,
                  fmt::format("all outputs must have one form to be repeated, but {} is in {} and {} in {}",
                              names.front(), like.outputs.front().unit, output.name, output.unit));
    }
  }
  blaming({file}, [&] { fem::select_outputs(scene, names); });
  Wanted wanted{like.frequency_hz, like.outputs.front().kind, like.exponential_decay};
  if (wanted.frequency_hz(0) == 0.0) {
    warn(fmt::format("{}: its line at 0 Hz is left out of the prediction", file));
    wanted.frequency_hz = Eigen::VectorXd(wanted.frequency_hz.tail(wanted.frequency_hz.size() - 1));
  }
  if (wanted.frequency_hz.size() == 0)
    throw Error(file, 0, "at least one line above 0 Hz is needed, got none");
  return wanted;
}

Wanted wanted_lines(const PredictArguments& arguments, const fem::Body& body, fem::Damping damping) {
  const Band band =
      arguments.band.empty() ? Band{default_from_hz, default_to_hz} : parse_band(arguments.band);
  const double resolution = arguments.resolution_hz > 0.0
                                ? arguments.resolution_hz
                                : default_resolution_hz(body, damping, band.lo_hz, band.hi_hz);
  if (arguments.band.empty() || arguments.resolution_hz == 0.0) {
    print(fmt::format(
        "lines from {:g} to {:g} Hz, every {:g} Hz (--band, --resolution, or --like to repeat a file's)",
        band.lo_hz, band.hi_hz, resolution));
  }
  return {uniform_lines(band, resolution), ident::FrfKind::unknown, 0.0, resolution};
}

/// What the files say of the body; nullopt when none belongs to it.
std::optional<ident::IdentifiedParameters> parameters_of(const std::string& body,
                                                         const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    ident::IdentifiedParameters identified = ident::read_parameters(file);
    if (identified.body == body) return identified;
  }
  return std::nullopt;
}

/// Whether the errors of what acts are known: without those of the damping the peaks would look sure.
bool has_covariance(const ident::IdentifiedParameters& identified, fem::Damping damping) {
  const auto known = [](const ident::IdentifiedCurve& curve) {
    return !curve.laws.empty() && curve.laws.front().covariance.size() > 0;
  };
  if (!known(identified.modulus)) return false;
  if (damping == fem::Damping::structural) return known(identified.loss_factor);
  return identified.rayleigh_known && identified.rayleigh.determined && identified.rayleigh.beta_sigma > 0.0;
}

std::vector<Choice> prediction_choices(const fem::Scene& scene, const PredictionMesh& mesh,
                                       const Wanted& wanted, bool resolution_given) {
  const fem::Body body = fem::linear_path(scene).body;
  const fem::Damping damping = mesh.request.damping;
  Choice elements = mesh_choice(body, mesh.request, mesh.choice);
  elements.why += fmt::format("; estimate before {:.1e}", *elements.error);
  elements.error = mesh.checked_error;
  std::vector<Choice> choices = {elements};
  if (wanted.resolution_hz > 0.0) {
    choices.push_back(lines_choice(body, damping, mesh.request.lo_hz, mesh.request.hi_hz,
                                   wanted.resolution_hz, resolution_given));
  } else {
    choices.push_back({.what = "lines", .value = "those of the file", .fixed = true, .why = "--like"});
  }
  choices.push_back({.what = "modes", .value = "all", .why = "the direct solution leaves none out"});
  choices.push_back({.what = "solution",
                     .value = scene.contacts.empty() ? "linear" : "linear, contact left out",
                     .fixed = !scene.contacts.empty(),
                     .why = scene.contacts.empty()
                                ? "no contact in the scene"
                                : "struna predict; struna simulate tells whether a gap closes"});
  choices.push_back(beam_theory_choice(body, mesh.request.hi_hz));
  return choices;
}

void run_predict(const PredictArguments& arguments) {
  const fem::Damping damping = option_value("--damping", arguments.damping, fem::damping_kind);
  if (!arguments.like.empty() && arguments.resolution_hz > 0.0) {
    throw UsageError("--resolution: the lines are those of the --like file; give one of the two");
  }
  fem::Scene scene = read_scene(arguments.scene);
  apply_parameters(scene, arguments.parameters);
  state_tolerance(scene, arguments.tolerance);
  const auto files = [&] {
    std::vector<std::string> all = {arguments.scene};
    all.insert(all.end(), arguments.parameters.begin(), arguments.parameters.end());
    return all;
  }();
  const fem::Body body = blaming(files, [&] { return fem::linear_path(scene); }).body;
  require_modulus(body, arguments.scene);
  const Wanted wanted = arguments.like.empty() ? wanted_lines(arguments, body, damping)
                                               : wanted_like(arguments.like, arguments.band, scene);
  const auto identified = parameters_of(body.name, arguments.parameters);
  for (const std::string& warning :
       prediction_warnings(scene, damping, wanted.frequency_hz, identified ? &*identified : nullptr))
    warn(warning);
  if (damping == fem::Damping::viscous && identified && identified->rayleigh_known)
    if (const std::string caveat = ident::caveat(identified->rayleigh); !caveat.empty())
      warn(fmt::format("Rayleigh coefficients of body '{}': {}", body.name, caveat));

  PredictionMesh mesh;
  const auto begin = std::chrono::steady_clock::now();
  const ident::TransferFunction tf = blaming(files, [&] {
    return predict(scene, damping, wanted.frequency_hz, wanted.form, &mesh,
                   identified ? &*identified : nullptr);
  });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (const auto warning = window_warning(wanted.exponential_decay, tf.exponential_decay))
    warn(arguments.like + ": " + *warning);
  ident::write_transfer_function(tf, arguments.to);

  print(
      fmt::format("{} lines, {} outputs [{}], {} damping, {} elements; largest estimated mesh error {:.2g} "
                  "of the outputs",
                  tf.lines(), tf.outputs.size(), tf.outputs.front().unit, fem::to_string(damping),
                  mesh.choice.elements, mesh.checked_error));
  if (const auto warning = mesh_warning(mesh)) warn(*warning);
  if (arguments.explain) {
    print("");
    print(explanation(fmt::format("sized for outputs within {:g} from {:g} to {:g} Hz; cost 1 is {:.2g} s",
                                  mesh.request.tolerance, mesh.request.lo_hz, mesh.request.hi_hz, seconds),
                      prediction_choices(scene, mesh, wanted, arguments.resolution_hz > 0.0)));
  }
}

bool is_zero(const fem::FrequencyLaw& law) {
  const std::vector<double>& numbers = law.value.empty() ? law.parameters : law.value;
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return number == 0.0; });
}

}  // namespace

std::vector<std::string> extrapolation_warnings(const fem::Body& body, fem::Damping damping,
                                                const Eigen::VectorXd& frequency_hz,
                                                const ident::IdentifiedParameters* identified) {
  std::vector<std::string> warnings;
  const auto check = [&](const fem::FrequencyLaw& law, const std::vector<ident::LawFit>& fitted,
                         const char* name) {
    long outside = 0;
    double sigma = 0.0;  // relative
    bool far = fitted.empty();
    for (const double f : frequency_hz) {
      if (!law.extrapolates_at(f)) continue;
      ++outside;
      far = far || ident::is_extrapolated(fitted, f);
      if (!fitted.empty()) sigma = std::max(sigma, ident::law_sigma(fitted, f) / law.at(f));
    }
    if (outside == 0) return;
    std::string text =
        fmt::format("body '{}': {} is {} at {} of {} frequencies: its data end at {:g} and {:g} Hz",
                    body.name, name, far ? "extrapolated" : "told beyond its data", outside,
                    frequency_hz.size(), law.valid_from_hz, law.valid_to_hz);
    if (sigma > 0.0) text += fmt::format("; standard error there up to {:.2g} %", 100.0 * sigma);
    warnings.push_back(text);
  };
  using Laws = std::vector<ident::LawFit>;
  check(body.material.youngs_modulus, identified ? identified->modulus.laws : Laws{}, "the modulus");
  if (damping == fem::Damping::structural)
    check(body.material.loss_factor, identified ? identified->loss_factor.laws : Laws{}, "the loss factor");
  return warnings;
}

std::optional<std::string> undamped_warning(const fem::Body& body, fem::Damping damping) {
  const fem::Material& material = body.material;
  const bool structural = damping == fem::Damping::structural;
  const bool damped = structural ? !is_zero(material.loss_factor)
                                 : material.rayleigh.alpha > 0.0 || material.rayleigh.beta > 0.0;
  if (damped) return std::nullopt;
  return fmt::format("body '{}' has no {}: the prediction with {} damping is undamped", body.name,
                     structural ? "loss factor" : "rayleigh coefficients", fem::to_string(damping));
}

std::vector<std::string> prediction_warnings(const fem::Scene& scene, fem::Damping damping,
                                             const Eigen::VectorXd& frequency_hz,
                                             const ident::IdentifiedParameters* identified) {
  const fem::Body body = fem::linear_path(scene).body;
  std::vector<std::string> warnings = extrapolation_warnings(body, damping, frequency_hz, identified);
  if (const auto undamped = undamped_warning(body, damping)) warnings.push_back(*undamped);
  if (!scene.contacts.empty()) {
    warnings.push_back("the scene's contact is left out of a linear prediction; struna simulate has it");
  }
  return warnings;
}

std::optional<std::string> mesh_warning(const PredictionMesh& mesh) {
  if (!(mesh.checked_error > (mesh.stated ? mesh.request.tolerance : quiet_mesh_error))) return std::nullopt;
  return fmt::format(
      "the mesh may be off by {:.2g} of the outputs at the worst line{}; more elements than {} in the scene "
      "help",
      mesh.checked_error, mesh.stated ? fmt::format(", tolerance {:g}", mesh.request.tolerance) : "",
      mesh.choice.elements);
}

std::optional<std::string> window_warning(double measured_decay, double predicted_decay) {
  if (measured_decay == predicted_decay) return std::nullopt;
  return fmt::format(
      "an exponential window adds {:.4g} 1/s to the decay of every measured mode, {:.4g} 1/s to that of the "
      "predicted ones: peaks agree in frequency, not in height and width",
      measured_decay, predicted_decay);
}

ident::TransferFunction predict(const fem::Scene& scene, fem::Damping damping,
                                const Eigen::VectorXd& frequency_hz, ident::FrfKind form,
                                PredictionMesh* mesh, const ident::IdentifiedParameters* identified) {
  if (frequency_hz.size() == 0) throw Error("predict: at least one frequency is needed, got none");
  const fem::LinearPath path = fem::linear_path(scene);
  const fem::SizedResponse sized = fem::sized_response(path.body, path.drive, path.measurement, frequency_hz,
                                                       damping, tolerance_of(scene, response_tolerance));
  const fem::HarmonicResponse& response = sized.response;
  if (mesh != nullptr) *mesh = {sized.request, sized.mesh, sized.checked_error, scene.tolerance > 0.0};
  Eigen::MatrixXd sigma;
  if (identified != nullptr && has_covariance(*identified, damping))
    sigma = ident::prediction_band(sized.model, path.drive, path.measurement, response, damping, *identified)
                .sigma();

  const ident::FrfKind natural = natural_kind(scene);
  const Eigen::ArrayXcd i_omega = std::complex<double>(0.0, 2.0 * std::numbers::pi) * frequency_hz.array();
  ident::TransferFunction tf;
  tf.frequency_hz = frequency_hz;
  for (std::size_t k = 0; k < scene.measurement->names.size(); ++k) {
    ident::TransferFunction::Output output;
    output.name = scene.measurement->names[k];
    output.kind = natural;
    output.unit = ident::unit_of(natural);
    output.value = response.response.col(static_cast<long>(k)).array() * i_omega.pow(derivative(scene));
    if (sigma.size() > 0)
      output.sigma = sigma.col(static_cast<long>(k)).array() * i_omega.abs().pow(derivative(scene));
    tf.outputs.push_back(std::move(output));
  }
  if (form == ident::FrfKind::unknown || form == natural) return tf;
  return ident::convert(tf, form);
}

void add_predict(CLI::App& app) {
  const auto arguments = std::make_shared<PredictArguments>();
  CLI::App* const predict =
      app.add_subcommand("predict", "transfer function of the scene's model, without contact");
  predict->add_option("SCENE.toml", arguments->scene, "the scene")->type_name("")->required();
  predict->add_option("-o", arguments->to, "predicted transfer function to write")
      ->type_name(written_file + std::string(".csv"))
      ->required();
  predict->add_option("--parameters", arguments->parameters, "identified.toml; may be repeated, one per body")
      ->type_name(read_file + std::string(".toml"))
      ->allow_extra_args(false);
  predict
      ->add_option("--like", arguments->like, "transfer function whose outputs, form and lines are repeated")
      ->type_name(read_file + std::string(".csv"));
  predict->add_option("--damping", arguments->damping, "structural (default) or viscous")->type_name("WORD");
  predict->add_option("--band", arguments->band, "lines [Hz]; default 10:1000, with --like all of its lines")
      ->type_name("LO:HI");
  predict
      ->add_option("--resolution", arguments->resolution_hz,
                   "line spacing; default 0.5, or finer where a resonance is narrow")
      ->type_name("HZ")
      ->check(refusal_of_hz);
  predict
      ->add_option("--tolerance", arguments->tolerance,
                   "of the outputs on the worst line; default: the scene's, or 0.001")
      ->type_name("NUMBER");
  predict->add_flag("--explain", arguments->explain,
                    "tell what was chosen, why, and what more or less would give");
  predict->footer(
      "Example:\n"
      "  struna predict scene.toml -o predicted.csv --parameters identified.toml --like trfam.csv\n"
      "  struna predict scene.toml -o predicted.csv --damping viscous --band 10:1000 --resolution 0.25\n"
      "  struna predict scene.toml -o predicted.csv --tolerance 0.01 --explain");
  predict->callback([arguments] { run_predict(*arguments); });
}

}  // namespace struna::apps
