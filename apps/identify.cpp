#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "apps/bootstrap.hpp"
#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/measured_transfer.hpp"
#include "apps/output_folder.hpp"
#include "apps/predict.hpp"
#include "apps/provenance.hpp"
#include "apps/report.hpp"
#include "apps/scene_file.hpp"
#include "apps/scene_fit.hpp"
#include "apps/study_file.hpp"
#include "fem/eigenmodes.hpp"
#include "ident/atomic_file.hpp"
#include "ident/comparison.hpp"
#include "ident/doubts.hpp"
#include "ident/mode_file.hpp"
#include "ident/parameter_file.hpp"
#include "ident/references.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

/// Everything that the command finds out, in the order in which it does.
struct Identification {
  MeasuredTransfer transfer;
  std::vector<ident::TransferEstimate> estimates;  ///< of each reference
  ident::ModeSet modes;
  SceneFit fit;
  ident::TransferFunction predicted;
  ident::TransferFunction predicted_viscous;
  PredictionMesh mesh;
  ident::Comparison comparison;
  ident::Comparison comparison_viscous;
  std::optional<ident::BootstrapScatter> bootstrap;
  std::vector<ident::Doubt> doubts;
  std::vector<std::string> warnings;
};

/// All references as one; how the first one was estimated stands for the others.
MeasuredTransfer measure(const Study& study, std::vector<ident::TransferEstimate>& estimates) {
  std::vector<ident::NamedReference> functions;
  MeasuredTransfer all;
  for (const StudyReference& reference : study.references) {
    std::vector<std::string> files = reference.records;
    files.push_back(study.file);
    MeasuredTransfer one = blaming(files, [&] {
      return measure_transfer(reference.records, reference.input, study.outputs,
                              corrections_of(study, reference), study.transfer);
    });
    functions.push_back({reference.name, reference.records.front(), one.function});
    if (functions.size() == 1) all.estimate = one.estimate;
    estimates.push_back(std::move(one.estimate));
    for (auto& warning : one.warnings)
      all.warnings.push_back(study.references.size() > 1 ? "reference " + reference.name + ": " + warning
                                                         : std::move(warning));
  }
  all.function = ident::combine_references(functions);
  return all;
}

fem::Scene scene_of(const Study& study) {
  fem::Scene scene = read_scene(study.scene);
  blaming({study.file}, [&] { fem::select_outputs(scene, study.outputs); });
  for (const StudyReference& reference : study.references) {
    if (!scene.drive || !reference.direction) continue;
    if (&reference == &study.references.front()) scene.drive->direction = *reference.direction;
    scene.drive->references[reference.name] = *reference.direction;
  }
  blaming({study.scene}, [&] { fem::linear_path(scene); });
  return scene;
}

ident::Provenance provenance_of(const Study& study, double band_lo_hz, double band_hi_hz) {
  std::vector<std::string> files = {study.file, study.scene};
  files.insert(files.end(), study.records.begin(), study.records.end());
  if (!study.transfer.fixture.empty()) files.push_back(study.transfer.fixture);
  return provenance(files, band_lo_hz, band_hi_hz);
}

/// Both predictions on the measured lines, with what is to be told of them.
void predict_both(Identification& found) {
  const ident::TransferFunction& measured = found.transfer.function;
  const auto tell = [&](const std::string& warning) {
    const bool told = std::count(found.warnings.begin(), found.warnings.end(), warning) > 0;
    if (!told) found.warnings.push_back(warning);
  };
  for (const auto damping : {fem::Damping::structural, fem::Damping::viscous}) {
    for (const auto& warning :
         prediction_warnings(found.fit.scene, damping, measured.frequency_hz, &found.fit.identified))
      tell(warning);
  }
  const ident::FrfKind form = measured.outputs.front().kind;
  fem::Scene scene = found.fit.scene;
  fem::select_outputs(scene, ident::output_names(measured));
  const ident::IdentifiedParameters* identified = &found.fit.identified;
  found.predicted =
      predict(scene, fem::Damping::structural, measured.frequency_hz, form, &found.mesh, identified);
  found.predicted_viscous =
      predict(scene, fem::Damping::viscous, measured.frequency_hz, form, nullptr, identified);
  if (const auto warning = mesh_warning(found.mesh)) tell(*warning);
  if (const auto warning = window_warning(measured.exponential_decay, found.predicted.exponential_decay)) {
    tell(*warning);
  }
}

Identification identify(const Study& study, std::optional<double> tolerance, long replicates) {
  if (replicates > 0 && !study.transfer.drive_signal.empty())
    throw Error(study.file, 0,
                "--bootstrap replicates outputs over an input and knows no drive_signal: take one out");
  fem::Scene scene = scene_of(study);
  state_tolerance(scene, tolerance);
  Identification found;

  progress("reading the records and estimating the transfer function");
  found.transfer = measure(study, found.estimates);
  found.warnings = found.transfer.warnings;
  const ident::TransferFunction& measured = found.transfer.function;

  progress("finding the modes");
  found.modes = blaming({study.file}, [&] { return ident::identify_modes(measured, study.modes); });
  if (found.modes.modes.empty()) {
    throw Error(study.file, 0,
                "no mode was found in the records; a band with resonances is needed, see [modes] band");
  }

  progress("fitting the model");
  found.fit = blaming({study.scene}, [&] { return fit_to_scene(scene, found.modes, study.fit); });
  const ident::Provenance& fitted = found.fit.identified.provenance;
  found.fit.identified.provenance = provenance_of(study, fitted.band_lo_hz, fitted.band_hi_hz);
  if (!has_modulus(fem::linear_path(found.fit.scene).body)) {
    throw Error(study.file, 0,
                "no measured mode could be trusted to stand for one of the model: check the scene's geometry "
                "and ends, the "
                "channels' order and the band");
  }

  for (std::string& line : inseparable_lines(found.fit.identified)) found.warnings.push_back(std::move(line));
  if (replicates > 0) {
    progress(fmt::format("bootstrap, {} replicates", replicates));
    found.bootstrap =
        blaming({study.file}, [&] { return bootstrap(study, found.estimates, found.modes, replicates); });
  }

  progress("predicting and comparing");
  blaming({study.scene}, [&] { predict_both(found); });
  blaming({study.file}, [&] {
    found.comparison = ident::compare(measured, found.predicted, study.compare.lo_hz, study.compare.hi_hz);
    found.comparison_viscous =
        ident::compare(measured, found.predicted_viscous, study.compare.lo_hz, study.compare.hi_hz);
  });
  found.doubts = found.fit.doubts;
  for (auto& doubt : ident::comparison_doubts(found.comparison, found.comparison_viscous, found.modes,
                                              found.fit.identified, found.fit.doubts)) {
    found.doubts.push_back(std::move(doubt));
  }
  if (found.bootstrap)
    if (const auto doubt = scatter_doubt(*found.bootstrap)) found.doubts.push_back(*doubt);
  for (const auto& name : found.comparison.not_compared) {
    found.warnings.push_back(name + ": not compared, the prediction does not have it");
  }
  return found;
}

std::vector<std::pair<std::string, std::string>> settings_of(const Study& study,
                                                             const Identification& found) {
  std::vector<std::pair<std::string, std::string>> settings = {
      {"records", fmt::format("{}", fmt::join(study.records, ", "))},
      {"input", study.input},
      {"form", ident::to_string(found.transfer.function.outputs.front().kind)}};
  for (auto& shown : transfer_settings_shown(found.transfer)) settings.push_back(std::move(shown));
  if (study.references.size() > 1) {
    std::vector<std::string> names;
    for (const auto& reference : study.references) names.push_back(reference.name);
    settings.emplace_back("references", fmt::format("{}", fmt::join(names, ", ")));
  }
  if (found.bootstrap) settings.emplace_back("error bars", bootstrap_line(*found.bootstrap));
  settings.emplace_back("mode method", ident::to_string(study.modes.method));
  settings.emplace_back("elements", std::to_string(found.fit.elements));
  settings.emplace_back("mesh error of the prediction", fmt::format("{:.1e}", found.mesh.checked_error));
  return settings;
}

Eigen::VectorXd model_frequencies(const SceneFit& fit) {
  const fem::Body body = fem::linear_path(fit.scene).body;
  const Eigen::VectorXd eigenvalue = fem::solve_eigenmodes(fem::assemble(body, fit.elements)).eigenvalue;
  return fem::natural_frequencies_hz(body, eigenvalue);
}

ReportContent report_content(const Study& study, const std::string& folder, const Identification& found) {
  ReportContent content;
  content.title = std::filesystem::path(study.file).parent_path().filename().string();
  if (content.title.empty()) content.title = std::filesystem::path(study.file).stem().string();
  content.command = "struna identify " + study.file + " -o " + folder;
  content.doubts = found.doubts;
  content.warnings = found.warnings;
  content.settings = settings_of(study, found);
  content.measured = found.transfer.function;
  content.predicted = found.predicted;
  content.predicted_viscous = found.predicted_viscous;
  content.modes = found.modes;
  content.identified = found.fit.identified;
  content.comparison = found.comparison;
  content.comparison_viscous = found.comparison_viscous;
  content.model_natural_frequency_hz = model_frequencies(found.fit);
  content.input_files = {{study.file, text_of_file(study.file)}, {study.scene, text_of_file(study.scene)}};
  return content;
}

void write(const Study& study, const std::string& folder, const Identification& found) {
  const std::string report = render_report(report_content(study, folder, found));
  fill_folder(folder, [&](const std::string& staging) {
    ident::write_transfer_function(found.transfer.function, staging + "/trfam.csv");
    ident::write_modes(found.modes, staging + "/modes.csv");
    ident::write_parameters(found.fit.identified, staging + "/identified.toml", found.doubts);
    ident::write_transfer_function(found.predicted, staging + "/predicted.csv");
    ident::write_transfer_function(found.predicted_viscous, staging + "/predicted_viscous.csv");
    ident::write_comparison(found.comparison, staging + "/comparison.csv");
    if (found.bootstrap) ident::write_bootstrap(found.modes, *found.bootstrap, staging + "/bootstrap.csv");
    ident::write_atomically(staging + "/report.html", report);
  });
}

/// Told before the records are read.
void refuse_overwriting_inputs(const Study& study, const std::string& folder) {
  std::vector<std::pair<std::string, std::string>> written;
  for (const char* name : {"trfam.csv", "modes.csv", "identified.toml", "predicted.csv",
                           "predicted_viscous.csv", "comparison.csv", "bootstrap.csv", "report.html"}) {
    written.emplace_back("-o", folder + "/" + name);
  }
  std::vector<std::string> read = study.records;
  read.insert(read.end(), {study.file, study.scene});
  if (!study.transfer.fixture.empty()) read.push_back(study.transfer.fixture);
  refuse_overwriting(written, read);
}

std::string range_of(const Eigen::VectorXd& values, const char* unit) {
  if (values.size() == 0) return "no mode is trusted for it";
  return fmt::format("{:.4g} to {:.4g}{}", values.minCoeff(), values.maxCoeff(), unit);
}

void print_summary(const std::string& folder, const Identification& found) {
  const auto& identified = found.fit.identified;
  print(trust_line(found.modes, identified) + "; body '" + identified.body + "'");
  print("modulus: " + range_of(1e-9 * identified.modulus.value, " GPa"));
  print("loss factor: " + range_of(identified.loss_factor.value, ""));
  for (const std::string& line : fitted_lines(identified)) print(line);
  if (const std::string line = scene_error_line(identified); !line.empty()) print(line);
  print(rayleigh_line(identified));
  const auto shown = [](double value, int digits) {
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
  };
  if (found.bootstrap) print(bootstrap_line(*found.bootstrap));
  Table table{{"output", "FRAC structural", "error [dB]", "FRAC viscous", "error [dB]"}, {}};
  for (std::size_t k = 0; k < found.comparison.outputs.size(); ++k) {
    const auto& structural = found.comparison.outputs[k];
    const auto& viscous = found.comparison_viscous.outputs[k];
    table.rows.push_back({structural.output, shown(structural.frac, 4),
                          shown(structural.log_magnitude_error_db, 2), shown(viscous.frac, 4),
                          shown(viscous.log_magnitude_error_db, 2)});
  }
  print(table);
  print("written to " + folder + "; open " + (std::filesystem::path(folder) / "report.html").string());
}

void print_explanation(const Identification& found) {
  print("");
  print(explanation(fmt::format("fit: sized for natural frequencies within {:g} up to {:g} Hz",
                                found.fit.request.tolerance, found.fit.request.hi_hz),
                    fit_choices(found.fit)));
  Choice elements =
      mesh_choice(fem::linear_path(found.fit.scene).body, found.mesh.request, found.mesh.choice);
  elements.why += fmt::format("; estimate before {:.1e}", *elements.error);
  elements.error = found.mesh.checked_error;
  std::vector<Choice> choices = {
      elements, {.what = "lines", .value = "those of the records", .why = "to be compared with them"}};
  for (const auto& [what, value] : transfer_settings_shown(found.transfer)) {
    if (what == "resolution" || what == "estimator")
      choices.push_back(
          {.what = what, .value = value, .why = "from the records or the study, see struna frf"});
  }
  print(explanation(
      fmt::format("prediction: sized for outputs within {:g} from {:g} to {:g} Hz",
                  found.mesh.request.tolerance, found.mesh.request.lo_hz, found.mesh.request.hi_hz),
      choices));
}

}  // namespace

void add_identify(CLI::App& app) {
  struct Options {
    std::string study;
    std::string folder;
    std::optional<double> tolerance;
    bool explain = false;
    long replicates = 0;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "identify", "from records to identified parameters, a compared prediction and a report");
  command->add_option("STUDY.toml", options->study, "scene, records, input, outputs and options")
      ->required()
      ->type_name("");
  command
      ->add_option(
          "-o,--output-folder", options->folder,
          "folder for trfam.csv modes.csv identified.toml predicted.csv predicted_viscous.csv comparison.csv "
          "report.html; made when missing")
      ->required()
      ->type_name("DIRECTORY");
  command
      ->add_option("--bootstrap", options->replicates,
                   "checks the error bars by so many replicates of the records, at least 10 (100 tell a "
                   "factor of 1.5): bootstrap.csv")
      ->check(CLI::Range(10L, 10000L).description(""))
      ->type_name("N");
  command
      ->add_option(
          "--tolerance", options->tolerance,
          "of the model: natural frequencies of the fit, outputs of the prediction; default: the scene's, or "
          "1e-5 and 0.001")
      ->type_name("NUMBER");
  command->add_flag("--explain", options->explain,
                    "tell what was chosen, why, and what more or less would give");
  command->footer(
      "Example:\n"
      "  struna identify sample_data/curved_wire/study.toml -o out\n\n"
      "Everything is worked out first and written at the end, all files or none.");
  command->callback([options] {
    check_folder(options->folder);
    const Study study = read_study(options->study);
    refuse_overwriting_inputs(study, options->folder);
    const Identification found = identify(study, options->tolerance, options->replicates);
    for (const auto& doubt : found.doubts) warn(ident::sentence(doubt));
    for (const auto& warning : found.warnings) warn(warning);
    write(study, options->folder, found);
    print_summary(options->folder, found);
    if (options->explain) print_explanation(found);
  });
}

}  // namespace struna::apps
