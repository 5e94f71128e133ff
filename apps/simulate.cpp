#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/provenance.hpp"
#include "apps/scene_file.hpp"
#include "apps/simulate_report.hpp"
#include "apps/simulation_sizing.hpp"
#include "apps/sizing.hpp"
#include "fem/simulation.hpp"
#include "ident/atomic_file.hpp"
#include "ident/record.hpp"
#include "ident/record_comparison.hpp"

namespace struna::apps {
namespace {

struct SimulateArguments {
  std::string scene;
  std::vector<std::string> parameters;
  std::string to;
  std::string method;
  std::string contacts_to;
  std::string report_to;
  std::string against;
  std::optional<double> tolerance;
  bool explain = false;
};

std::atomic<bool> interrupted_ = false;

/// While it lives, the first Ctrl-C asks the run to stop; the second one ends the program as usual.
class InterruptGuard {
 public:
  InterruptGuard() {
    interrupted_ = false;
    previous_ = std::signal(SIGINT, [](int) {
      interrupted_ = true;
      std::signal(SIGINT, SIG_DFL);
    });
  }
  ~InterruptGuard() { std::signal(SIGINT, previous_); }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void (*previous_)(int) = SIG_DFL;
};

/// Tells every two seconds how far a run is and how long it will still take.
class RunProgress {
 public:
  explicit RunProgress(double duration) : duration_(duration) {}
  bool operator()(double time) {
    using Clock = std::chrono::steady_clock;
    const auto now = Clock::now();
    if (time < last_time_) begin_ = now;  // the run with contact starts over
    last_time_ = time;
    const double spent = std::chrono::duration<double>(now - begin_).count();
    if (time > 0.0 && std::chrono::duration<double>(now - told_).count() > 2.0) {
      progress(fmt::format("simulated {:.3g} of {:g} s, {:.0f} s left", time, duration_,
                           spent * (duration_ - time) / time));
      told_ = now;
    }
    return !interrupted_;
  }

 private:
  double duration_;
  double last_time_ = 0.0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point told_ = begin_;
};

bool is_force_drive(const fem::Scene& scene) {
  return scene.drive && std::holds_alternative<fem::BodyPoint>(scene.drive->at);
}

/// The motion that the scene asks for; a record's samples are read here.
fem::MotionHistory motion_of(const fem::Scene& scene) {
  const fem::Excitation& excitation = scene.simulation->excitation;
  if (excitation.kind != fem::Excitation::Kind::record) return fem::scene_motion(scene);
  const ident::Record record = ident::read_record(excitation.file, {excitation.column});
  const auto wanted = is_force_drive(scene) ? ident::Quantity::force : ident::Quantity::displacement;
  const auto got = record.channels.front().quantity;
  if (got != wanted) {
    const char* cure = wanted == ident::Quantity::displacement
                           ? "a moved support needs a displacement, since integrating others would drift"
                           : "a driven point needs a force";
    throw Error(excitation.file, 1,
                fmt::format("column '{}' is in [{}], but {}", excitation.column, ident::si_unit(got), cure));
  }
  const double lasts = static_cast<double>(record.samples.rows() - 1) * record.sample_interval;
  if (lasts < scene.simulation->duration - 1.0 / scene.simulation->sample_rate) {
    throw Error(excitation.file, 0,
                fmt::format("the record lasts {:g} s, less than the scene's duration = {:g} s", lasts,
                            scene.simulation->duration));
  }
  return blaming({excitation.file},
                 [&] { return fem::motion_from_samples(record.samples.col(0), record.sample_interval); });
}

ident::Quantity quantity_of(const fem::SceneMeasurement& measurement) {
  if (std::holds_alternative<fem::Support>(measurement.at)) return ident::Quantity::force;
  switch (measurement.quantity) {
    case fem::MotionQuantity::displacement:
      return ident::Quantity::displacement;
    case fem::MotionQuantity::velocity:
      return ident::Quantity::velocity;
    case fem::MotionQuantity::acceleration:
      break;
  }
  return ident::Quantity::acceleration;
}

std::string drive_name(const fem::Scene& scene) {
  return is_force_drive(scene) ? "drive_force" : "displacement";
}

ident::Record record_of(const fem::Scene& scene, const fem::TimeResponse& response) {
  ident::Record record;
  record.sample_interval = response.sample_interval;
  record.channels.push_back({drive_name(scene),
                             is_force_drive(scene) ? ident::Quantity::force : ident::Quantity::displacement,
                             0.0});
  for (const auto& name : response.names)
    record.channels.push_back({name, quantity_of(*scene.measurement), 0.0});
  record.samples.resize(response.motion.size(), response.output.cols() + 1);
  record.samples << response.motion, response.output;
  return record;
}

/// Long form: one row per time bin and contact point.
void write_contacts(const fem::TimeResponse& response, const std::string& file) {
  std::string text = "time [s],inside,outside,arc_length [m],penetration [m],force [N]\n";
  for (const auto& map : response.contacts) {
    for (long bin = 0; bin < map.penetration.rows(); ++bin) {
      for (long point = 0; point < map.arc_length.size(); ++point) {
        text += fmt::format("{:.9g},{},{},{:.9g},{:.6g},{:.6g}\n",
                            (static_cast<double>(bin) + 0.5) * map.interval, map.inside, map.outside,
                            map.arc_length[point], map.penetration(bin, point), map.force(bin, point));
      }
    }
  }
  ident::write_atomically(file, text);
}

using Rows = std::vector<std::pair<std::string, std::string>>;

/// What the program chose and found.
Rows report_rows(const fem::SimulationReport& report) {
  Rows rows;
  const auto add = [&](const std::string& what, const std::string& value) { rows.emplace_back(what, value); };
  add("method", report.method == fem::IntegrationMethod::modal ? "modal" : "newmark");
  if (report.linear) {
    add("solution", report.largest_offset > 0.0
                        ? fmt::format("linear: no gap closes, the nearest reaches {:.1f} %",
                                      100.0 * report.largest_offset)
                        : "linear: no contact");
  } else {
    add("solution", fmt::format("{} contact events", report.steps.events));
    add("deepest penetration [m]", fmt::format("{:.4g}", report.steps.largest_penetration));
  }
  if (report.tolerance > 0.0) {
    const bool checked = report.method == fem::IntegrationMethod::modal || !report.linear;
    add("tolerance asked", fmt::format("{:g} of the largest displacement{}", report.tolerance,
                                       checked ? "" : "; sets the step, is not checked"));
  }
  if (report.estimated_error > 0.0) {
    add("error estimated", fmt::format("{:.2g}, against a refined run up to {:.4g} s", report.estimated_error,
                                       report.error_checked_until));
  }
  if (report.step > 0.0) add("step [s]", fmt::format("{:g}", report.step));
  add("steps free + in contact", fmt::format("{} + {}", report.steps.free_steps, report.steps.contact_steps));
  if (report.method == fem::IntegrationMethod::modal) {
    add("modes stepped + static + idle",
        fmt::format("{} + {} + {}{}", report.steps.modes, report.steps.static_modes, report.steps.idle_modes,
                    report.steps.planar ? ", in one plane" : ""));
  }
  if (report.highest_mode_hz > 0.0)
    add("modes that follow statically", fmt::format("above {:.4g} Hz", report.highest_mode_hz));
  if (report.causal_distance) {
    add("causal law off the harmonic response",
        fmt::format("{:.2g} %, rms over the band, without contact", 100.0 * *report.causal_distance));
  }
  if (report.steps.lasting_contacts > 0) {
    add("impacts that became lasting contacts",
        fmt::format("{}: stiffness and damping act in them", report.steps.lasting_contacts));
  }
  if (report.energy) {
    const auto& energy = *report.energy;
    const double given = energy.initial + energy.input;
    add("energy at the start + put in [J]", fmt::format("{:.4g} + {:.4g}", energy.initial, energy.input));
    add("at the end + lost in bodies + in contacts [J]",
        fmt::format("{:.4g} + {:.4g} + {:.4g}", energy.kinetic + energy.strain + energy.contact_stored,
                    energy.body_dissipated, energy.contact_dissipated));
    if (energy.static_jumps != 0.0) {
      add("in jumps of the static modes [J]",
          fmt::format("{:.2g}, lost (negative: given) because they follow a force at once",
                      energy.static_jumps));
    }
    add("imbalance, of the first two",
        fmt::format("{:.1e}", given != 0.0 ? energy.imbalance() / given : 0.0));
  }
  for (const auto& body : report.bodies) {
    add(fmt::format("'{}'", body.name),
        fmt::format("{} elements, largest slope {:.3g} rad, bending strain {:.2g}", body.elements,
                    body.largest_slope, body.largest_bending_strain));
  }
  return rows;
}

void print_rows(const Rows& rows) {
  Table table{{"what", "value"}, {}};
  for (const auto& [what, value] : rows) table.rows.push_back({what, value});
  print(table);
}

/// The record to compare with: the drive's motion (or force) and every output that will be simulated.
MeasuredBeside read_measured(const std::string& file, const fem::Scene& scene) {
  std::vector<std::string> columns = {drive_name(scene)};
  columns.insert(columns.end(), scene.measurement->names.begin(), scene.measurement->names.end());
  MeasuredBeside measured;
  measured.file = file;
  measured.record = ident::read_record(file, columns);
  const fem::Simulation& simulation = *scene.simulation;
  blaming({file}, [&] {
    ident::require_comparable(measured.record, 1.0 / simulation.sample_rate,
                              fem::sample_intervals(simulation));
  });
  return measured;
}

/// Compares and tells: a line per output.
void compare_with(MeasuredBeside& measured, const ident::Record& simulated) {
  measured.comparison =
      blaming({measured.file}, [&] { return ident::compare_records(measured.record, simulated); });
  // Resampled or rounded motions correlate better than this, different ones never do.
  constexpr double same_motion = 0.99;
  if (!(measured.comparison.motion_correlation > same_motion)) {
    warn(
        fmt::format("the motion in {} is not the one that drove the simulation (correlation {:.3f}): sample "
                    "by sample the two "
                    "have nothing to do with each other",
                    measured.file, measured.comparison.motion_correlation));
  }
  Table table{{"output", "correlation per second", "of all", "largest level difference [dB]"}, {}};
  for (const auto& signal : measured.comparison.signals) {
    table.rows.push_back(
        {signal.name,
         fmt::format("{:.3f} to {:.3f}", signal.correlation.minCoeff(), signal.correlation.maxCoeff()),
         fmt::format("{:.3f}", signal.correlation_of_all),
         fmt::format("{:.2f}", signal.level_db.cwiseAbs().maxCoeff())});
  }
  print(table);
}

std::string command_line(const SimulateArguments& arguments) {
  std::string line = "struna simulate " + arguments.scene;
  for (const auto& file : arguments.parameters) line += " --parameters " + file;
  if (!arguments.method.empty()) line += " --method " + arguments.method;
  if (!arguments.against.empty()) line += " --against " + arguments.against;
  return line + " -o " + arguments.to + " --report " + arguments.report_to;
}

Eigen::VectorXd acceleration_of(const fem::Scene& scene, const fem::MotionHistory& motion,
                                const ident::Record& record) {
  if (is_force_drive(scene)) return {};
  Eigen::VectorXd acceleration(record.samples.rows());
  for (long i = 0; i < acceleration.size(); ++i)
    acceleration[i] = motion.at(static_cast<double>(i) * record.sample_interval).acceleration;
  return acceleration;
}

SimulationReportContent report_content(const SimulateArguments& arguments, const fem::Scene& scene,
                                       const fem::MotionHistory& motion, const fem::TimeResponse& response,
                                       const ident::Record& record, std::optional<MeasuredBeside> measured) {
  SimulationReportContent content;
  const std::filesystem::path scene_path(arguments.scene);
  content.title =
      fmt::format("{} {}", std::filesystem::absolute(scene_path).parent_path().filename().string(),
                  scene_path.stem().string());
  content.command = command_line(arguments);
  std::vector<std::string> files = {arguments.scene};
  files.insert(files.end(), arguments.parameters.begin(), arguments.parameters.end());
  for (const auto& file : files) content.input_files.emplace_back(file, text_of_file(file));
  const std::string& driving = scene.simulation->excitation.file;
  if (!driving.empty()) files.push_back(driving);
  if (measured && measured->file != driving) files.push_back(measured->file);
  content.provenance = provenance(files, 0.0, 0.0);
  content.chosen = report_rows(response.report);
  content.record = record;
  content.base_acceleration = acceleration_of(scene, motion, record);
  content.report = response.report;
  content.contacts = response.contacts;
  // With contact the record has passed the anti-alias filter, which is flat up to 0.4 of its rate.
  content.highest_hz = (response.report.linear ? 0.5 : 0.4) / record.sample_interval;
  const Band band = excited_band(scene, record);
  content.transfer = record_transfer(record, band);
  const Eigen::VectorXd& lines = content.transfer.spectra.frequency_hz;
  if (lines.size() > 1) content.linear_at_spectra = without_contact(scene, lines.tail(lines.size() - 1));
  content.linear = without_contact(scene, content.transfer.function.frequency_hz);
  content.measured = std::move(measured);
  if (content.measured) content.measured->transfer = record_transfer(content.measured->record, band);
  return content;
}

fem::IntegrationMethod method_of(const std::string& word) {
  if (word == "modal") return fem::IntegrationMethod::modal;
  if (word == "newmark") return fem::IntegrationMethod::newmark;
  throw Error(fmt::format("must be modal or newmark, got '{}'", word));
}

void run_simulate(const SimulateArguments& arguments) {
  fem::Scene scene = read_scene(arguments.scene);
  apply_parameters(scene, arguments.parameters);
  for (const auto& body : scene.bodies) require_modulus(body, arguments.scene);
  if (!scene.simulation)
    throw Error(arguments.scene, 0, "a [simulation] with duration and excitation is needed");
  state_tolerance(scene, arguments.tolerance);
  if (!arguments.method.empty())
    scene.simulation->method = option_value("--method", arguments.method, method_of);
  refuse_overwriting(
      {{"-o", arguments.to}, {"--contacts", arguments.contacts_to}, {"--report", arguments.report_to}},
      {scene.simulation->excitation.file});
  const auto motion =
      blaming({arguments.scene, scene.simulation->excitation.file}, [&] { return motion_of(scene); });

  std::optional<MeasuredBeside> measured;
  if (!arguments.against.empty() && scene.measurement) measured = read_measured(arguments.against, scene);

  const InterruptGuard guard;
  const auto response = blaming({arguments.scene}, [&] {
    return fem::simulate(scene, motion, RunProgress(scene.simulation->duration), warn, arguments.explain);
  });
  if (response.motion.size() < 2) {
    throw Error(response.report.complete
                    ? fmt::format("the duration {:g} s holds one sample at {:g} Hz; a record needs 2 or more",
                                  scene.simulation->duration, scene.simulation->sample_rate)
                    : "simulate: interrupted before anything was computed; no file written");
  }
  const ident::Record record = record_of(scene, response);
  ident::write_record(record, arguments.to);
  if (!arguments.contacts_to.empty()) write_contacts(response, arguments.contacts_to);
  print_rows(report_rows(response.report));
  if (arguments.explain) print("\n" + simulation_explanation(scene, response.report));
  if (!response.report.complete) measured.reset();
  if (measured) compare_with(*measured, record);
  if (!arguments.report_to.empty()) {
    ident::write_atomically(arguments.report_to, render_simulation_report(report_content(
                                                     arguments, scene, motion, response, record, measured)));
  }
  if (!response.report.complete) {
    throw Error(fmt::format("simulate: interrupted at {:g} s of {:g} s; {} holds what was computed",
                            static_cast<double>(response.motion.size()) * response.sample_interval,
                            scene.simulation->duration, arguments.to));
  }
}

}  // namespace

void add_simulate(CLI::App& app) {
  const auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* const simulate =
      app.add_subcommand("simulate", "records of a scene run in time, contact included");
  simulate->add_option("SCENE.toml", arguments->scene, "scene with [simulation]")->type_name("")->required();
  simulate
      ->add_option("--parameters", arguments->parameters, "identified.toml; may be repeated, one per body")
      ->type_name("FILE.toml")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  simulate->add_option("-o", arguments->to, "records CSV to write")->required()->type_name("OUT.csv");
  simulate->add_option("--method", arguments->method, "modal or newmark, instead of the scene's");
  simulate
      ->add_option("--contacts", arguments->contacts_to,
                   "CSV of penetration and force per contact point, the largest sample in each of 2000 bins")
      ->type_name("OUT.csv");
  simulate
      ->add_option("--report", arguments->report_to,
                   "page to write: waveforms, contact map, spectra, transfer functions, energy")
      ->type_name("OUT.html");
  simulate
      ->add_option("--against", arguments->against,
                   "measured records CSV whose motion drives the scene: correlation and levels")
      ->type_name("FILE.csv");
  simulate
      ->add_option("--tolerance", arguments->tolerance,
                   "of the largest displacement, instead of the scene's; default 0.001")
      ->type_name("NUMBER");
  simulate->add_flag("--explain", arguments->explain,
                     "tell what was chosen, why, and what more or less would give (with contact: tried)");
  simulate->footer(
      "Ctrl-C stops a run; what was computed is written, exit code 1.\n"
      "Examples:\n"
      "  struna simulate scene.toml -o records.csv\n"
      "  struna simulate scene.toml --parameters identified.toml -o records.csv --contacts contacts.csv\n"
      "  struna simulate scene.toml -o records.csv --report report.html --against measured.csv");
  simulate->callback([arguments] { run_simulate(*arguments); });
}

}  // namespace struna::apps
