#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/measured_transfer.hpp"
#include "apps/output_folder.hpp"
#include "apps/scene_file.hpp"
#include "apps/tradeoff_harmonic.hpp"
#include "apps/tradeoff_model.hpp"
#include "apps/tradeoff_modes.hpp"
#include "apps/tradeoff_page.hpp"
#include "apps/tradeoff_simulation.hpp"
#include "apps/tradeoff_svg.hpp"
#include "apps/tradeoff_transfer.hpp"
#include "ident/atomic_file.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

/// Simulated seconds of a user's scene that are compared at most.
constexpr double longest_simulation = 0.15;

struct TradeoffArguments {
  std::vector<std::string> stages;
  std::string study;
  std::string scene;
  std::vector<std::string> parameters;
  std::string trfam;
  std::string band = "10:1000";
  std::string to;

  bool has_data() const { return !study.empty() || !scene.empty() || !trfam.empty(); }
};

using Charts = std::vector<TradeoffChart>;

/// A stage on the data given, or on its built-in problems.
struct Task {
  std::string stage;
  std::function<Charts(const TradeoffRun&)> charts;
};

/// The stages in the order of the data, from records to a simulated scene.
const std::vector<std::pair<std::string, std::string>> headings = {
    {"transfer", "Transfer function: estimator, window, resolution, record length"},
    {"modes", "Modes: method, noise, lines per bandwidth"},
    {"model", "Beam model: elements, geometry, mass"},
    {"harmonic", "Harmonic response: direct or modal, modes kept"},
    {"simulation", "Simulation: method, step, tolerance, modes, contact law"}};

std::vector<Task> built_in_tasks() {
  return {{"transfer", [](const TradeoffRun& run) { return tradeoff_transfer(run); }},
          {"modes", [](const TradeoffRun& run) { return tradeoff_modes(run); }},
          {"model", [](const TradeoffRun& run) { return tradeoff_model(run); }},
          {"harmonic", [](const TradeoffRun& run) { return tradeoff_harmonic(run); }},
          {"simulation", [](const TradeoffRun& run) { return tradeoff_simulation(run); }}};
}

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

void add_study_tasks(const std::string& file, std::vector<Task>& tasks) {
  const Study study = read_study(file);
  if (study.references.size() > 1)
    throw Error(file, 0,
                "has several references, of which the charts could measure one: name its records alone");
  tasks.push_back({"transfer", [file, study](const TradeoffRun& run) {
                     return blaming(study.records, [&] {
                       return Charts{
                           tradeoff_resolution(study_transfer_problem(study, file_name(file)), run)};
                     });
                   }});
  tasks.push_back({"modes", [file, study](const TradeoffRun& run) {
                     return blaming(study.records, [&] {
                       const MeasuredTransfer measured = measure_transfer(
                           study.records, study.input, study.outputs, study.corrections, study.transfer);
                       return tradeoff_modes(measured_modes_problem(measured.function, file_name(file)), run);
                     });
                   }});
}

void add_trfam_task(const std::string& file, std::vector<Task>& tasks) {
  std::vector<std::string> warnings;
  const ident::TransferFunction tf = ident::read_transfer_function(file, &warnings);
  for (const auto& warning : warnings) warn(warning);
  tasks.push_back({"modes", [file, tf](const TradeoffRun& run) {
                     return blaming({file}, [&] {
                       return tradeoff_modes(measured_modes_problem(tf, file_name(file)), run);
                     });
                   }});
}

void add_scene_tasks(const TradeoffArguments& arguments, std::vector<Task>& tasks) {
  const std::string& file = arguments.scene;
  fem::Scene scene = read_scene(file);
  apply_parameters(scene, arguments.parameters);
  for (const auto& body : scene.bodies) require_modulus(body, file);
  const Band band = parse_band(arguments.band);
  const std::string name = file_name(file);
  if (scene.drive && scene.measurement) {
    const LinearProblem problem = blaming({file}, [&] { return scene_problem(scene, name, band); });
    tasks.push_back({"model", [file, problem](const TradeoffRun& run) {
                       return blaming({file}, [&] { return tradeoff_model(problem, run); });
                     }});
    tasks.push_back({"harmonic", [file, problem](const TradeoffRun& run) {
                       return blaming({file}, [&] { return tradeoff_harmonic(problem, run); });
                     }});
  }
  if (scene.simulation) {
    tasks.push_back({"simulation", [file, name, scene](const TradeoffRun& run) {
                       return blaming({file, scene.simulation->excitation.file}, [&] {
                         return tradeoff_simulation(scene_simulation_problem(scene, name, longest_simulation),
                                                    run);
                       });
                     }});
  }
}

std::vector<Task> tasks_of(const TradeoffArguments& arguments) {
  if (!arguments.has_data()) return built_in_tasks();
  std::vector<Task> tasks;
  if (!arguments.study.empty()) add_study_tasks(arguments.study, tasks);
  if (!arguments.trfam.empty()) add_trfam_task(arguments.trfam, tasks);
  if (!arguments.scene.empty()) add_scene_tasks(arguments, tasks);
  if (tasks.empty()) {
    throw Error(arguments.scene, 0, "has neither [drive] and [measure] nor [simulation]: nothing to compare");
  }
  return tasks;
}

std::vector<Task> chosen_tasks(const TradeoffArguments& arguments) {
  for (const auto& name : arguments.stages) {
    const bool known =
        std::any_of(headings.begin(), headings.end(), [&](const auto& stage) { return stage.first == name; });
    if (!known)
      throw UsageError(
          fmt::format("--stage: must be transfer, modes, model, harmonic or simulation, got '{}'", name));
  }
  std::vector<Task> tasks = tasks_of(arguments);
  if (arguments.stages.empty()) return tasks;
  std::string offered;
  for (const auto& task : tasks) offered += (offered.empty() ? "" : ", ") + task.stage;
  std::vector<Task> chosen;
  for (const auto& task : tasks) {
    if (std::count(arguments.stages.begin(), arguments.stages.end(), task.stage) > 0) chosen.push_back(task);
  }
  for (const auto& name : arguments.stages) {
    const bool there =
        std::any_of(chosen.begin(), chosen.end(), [&](const Task& task) { return task.stage == name; });
    if (!there) throw UsageError(fmt::format("--stage {}: the data given speak of {} only", name, offered));
  }
  return chosen;
}

/// The front and the default; every row is in the CSV.
void print_chart(const TradeoffChart& chart) {
  print(fmt::format("{} ({})", chart_title(chart), chart.stage));
  Table table{{"method", "knob", "value", "error", "time", ""}, {}};
  for (const auto& row : chart.rows) {
    if (!row.pareto && !row.is_default) continue;
    table.rows.push_back({row.method, row.knob, fmt::format("{:.4g}", row.value),
                          fmt::format("{:.2e}", row.error), seconds_text(row.seconds),
                          row.is_default ? row.pareto ? "default, on the front" : "default" : ""});
  }
  print(table);
  if (chart.reference_error > 0.0)
    print(fmt::format("error of the reference itself: {:.1e}", chart.reference_error));
  print(advice(chart));
  for (const auto& row : better_than_default(chart)) {
    print(fmt::format("quicker and more accurate than the default, both by more than 1.5: {}, {}", row.method,
                      row_label(row)));
  }
  print("");
}

std::string heading_of(const std::string& stage) {
  return std::find_if(headings.begin(), headings.end(),
                      [&](const auto& entry) { return entry.first == stage; })
      ->second;
}

void run_tradeoff(const TradeoffArguments& arguments, const std::string& command) {
  const std::vector<Task> tasks = chosen_tasks(arguments);
  check_folder(arguments.to);
  TradeoffRun run;
  run.progress = [](const std::string& message) { progress(message); };
  std::vector<TradeoffStage> stages;
  Charts all;
  for (const auto& task : tasks) {
    const Charts charts = task.charts(run);
    for (const auto& chart : charts) print_chart(chart);
    all.insert(all.end(), charts.begin(), charts.end());
    const auto same = std::find_if(stages.begin(), stages.end(),
                                   [&](const TradeoffStage& stage) { return stage.name == task.stage; });
    if (same == stages.end())
      stages.push_back({task.stage, heading_of(task.stage), charts});
    else
      same->charts.insert(same->charts.end(), charts.begin(), charts.end());
  }
  fill_folder(arguments.to, [&](const std::string& staging) {
    ident::write_atomically(staging + "/tradeoff.csv", tradeoff_csv(all));
    ident::write_atomically(staging + "/index.html", tradeoff_page(stages, command));
    for (const auto& stage : stages) {
      ident::write_atomically(fmt::format("{}/tradeoff_{}.svg", staging, stage.name),
                              tradeoff_svg(stage.charts));
    }
  });
}

std::string command_line(const TradeoffArguments& arguments) {
  std::string line = "struna tradeoff";
  for (const auto& stage : arguments.stages) line += " --stage " + stage;
  if (!arguments.study.empty()) line += " --study " + arguments.study;
  if (!arguments.trfam.empty()) line += " --trfam " + arguments.trfam;
  if (!arguments.scene.empty()) line += " --scene " + arguments.scene + " --band " + arguments.band;
  for (const auto& file : arguments.parameters) line += " --parameters " + file;
  return line + " -o " + arguments.to;
}

}  // namespace

void add_tradeoff(CLI::App& app) {
  const auto arguments = std::make_shared<TradeoffArguments>();
  CLI::App* const tradeoff =
      app.add_subcommand("tradeoff", "error against time of every method, on your data or built-in problems");
  tradeoff->add_option("-o", arguments->to, "folder for tradeoff.csv, index.html and an SVG per stage")
      ->required()
      ->type_name("DIRECTORY");
  tradeoff
      ->add_option(
          "--stage", arguments->stages,
          "transfer, modes, model, harmonic or simulation; may be repeated; default: every stage that "
          "the data given speak of")
      ->type_name("NAME")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  tradeoff->add_option("--study", arguments->study, "a study: transfer and modes, on its records")
      ->type_name(read_file + std::string(".toml"));
  tradeoff->add_option("--trfam", arguments->trfam, "a transfer function: modes")
      ->type_name(read_file + std::string(".csv"));
  CLI::Option* const scene =
      tradeoff->add_option("--scene", arguments->scene, "a scene: model, harmonic and simulation")
          ->type_name(read_file + std::string(".toml"));
  tradeoff
      ->add_option("--parameters", arguments->parameters, "identified.toml; may be repeated, one per body")
      ->type_name(read_file + std::string(".toml"))
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->needs(scene);
  tradeoff->add_option("--band", arguments->band, "of model and harmonic on a scene [Hz]; default 10:1000")
      ->type_name("LO:HI")
      ->needs(scene);
  tradeoff->footer(
      "Without --study, --trfam or --scene: built-in problems, about two minutes for all stages.\n"
      "Examples:\n"
      "  struna tradeoff -o out\n"
      "  struna tradeoff --stage model --scene scene.toml --band 10:500 -o out\n"
      "  struna tradeoff --study study.toml -o out");
  tradeoff->callback([arguments] { run_tradeoff(*arguments, command_line(*arguments)); });
}

}  // namespace struna::apps
