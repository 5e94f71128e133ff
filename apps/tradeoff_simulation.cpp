#include "apps/tradeoff_simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "fem/error.hpp"
#include "fem/simulation.hpp"
#include "ident/record.hpp"

namespace struna::apps {
namespace {

constexpr double reference_tolerance = 1e-6;
constexpr double reference_step = 2e-6;  ///< [s]; of the run that the reference is checked against
/// Of the largest displacement: where reference and check differ by more, trajectories have parted.
constexpr double parted = 1e-3;

/// A way to step a scene.
struct Way {
  std::string name;
  fem::IntegrationMethod method = fem::IntegrationMethod::modal;
  double tolerance = 0.0;  ///< one of the two
  double step = 0.0;       ///< [s]
};

std::vector<Way> ways() {
  std::vector<Way> all;
  for (const double tolerance : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4})
    all.push_back({"modal; to a tolerance", fem::IntegrationMethod::modal, tolerance, 0.0});
  for (const double step : {5e-5, 2e-5, 1e-5, 5e-6})
    all.push_back({"modal; fixed step", fem::IntegrationMethod::modal, 0.0, step});
  for (const double step : {5e-5, 2e-5, 1e-5})
    all.push_back({"newmark", fem::IntegrationMethod::newmark, 0.0, step});
  return all;
}

fem::Scene scene_for(const SimulationProblem& problem, const Way& way) {
  fem::Scene scene = problem.scene;
  fem::Simulation& simulation = *scene.simulation;
  simulation.duration = problem.duration;
  simulation.method = way.method;
  simulation.tolerance = way.tolerance > 0.0 ? way.tolerance : fem::Simulation{}.tolerance;
  simulation.step = way.step;
  return scene;
}

/// The same scene, read as the displacement at the middle of the measured body along the drive.
fem::Scene watched(fem::Scene scene) {
  const std::string body = std::visit([](const auto& place) { return place.body; }, scene.measurement->at);
  scene.measurement = fem::SceneMeasurement{fem::BodyPoint{body, 0.5},
                                            fem::MotionQuantity::displacement,
                                            {"displacement"},
                                            {scene.drive->direction}};
  return scene;
}

/// The spectra of the outputs at the multiples of 1/T in the band, lines x outputs.
Eigen::MatrixXcd band_spectra(const Eigen::MatrixXd& output, double rate, double lo_hz, double hi_hz) {
  const double duration = static_cast<double>(output.rows()) / rate;
  const auto first = static_cast<long>(std::max(1.0, std::ceil(lo_hz * duration)));
  const auto last = static_cast<long>(std::floor(hi_hz * duration));
  const Eigen::MatrixXd centred = output.rowwise() - output.colwise().mean();
  Eigen::MatrixXcd spectra(std::max(last - first + 1, 0L), output.cols());
  Eigen::VectorXcd wave(output.rows());
  for (long line = first; line <= last; ++line) {
    const double turn =
        2.0 * std::numbers::pi * static_cast<double>(line) / static_cast<double>(output.rows());
    for (long i = 0; i < wave.size(); ++i) wave(i) = std::polar(1.0, -turn * static_cast<double>(i));
    spectra.row(line - first) = wave.transpose() * centred;
  }
  return spectra;
}

struct Solved {
  Eigen::VectorXd displacement;
  Eigen::MatrixXcd spectra;
  double seconds = 0.0;
};

Solved solve(const SimulationProblem& problem, const Way& way, const Timing& timing) {
  const fem::Scene scene = scene_for(problem, way);
  const fem::Excitation& excitation = scene.simulation->excitation;
  Solved solved;
  fem::TimeResponse response;
  solved.seconds = best_seconds(timing, [&] { response = fem::simulate(scene, problem.motion); });
  const double rate = 1.0 / response.sample_interval;
  const double hi = excitation.band_hi_hz > 0.0 ? excitation.band_hi_hz : 0.4 * rate;
  solved.spectra = band_spectra(response.output, rate, excitation.band_lo_hz, std::min(hi, 0.4 * rate));
  solved.displacement = fem::simulate(watched(scene), problem.motion).output.col(0);
  return solved;
}

double displacement_error(const Solved& run, const Solved& reference) {
  const double error = (run.displacement - reference.displacement).cwiseAbs().maxCoeff();
  return error / reference.displacement.cwiseAbs().maxCoeff();
}

double transfer_error(const Solved& run, const Solved& reference) {
  return (run.spectra - reference.spectra).norm() / reference.spectra.norm();
}

/// The way that reference and check go.
Way reference_way() {
  return {"", fem::IntegrationMethod::modal, reference_tolerance, 0.0};
}
Way check_way() {
  return {"", fem::IntegrationMethod::modal, 0.0, reference_step};
}

/// Duration over which reference and check stay together [s]: where they first differ, less a sample.
double common_duration(const Solved& reference, const Solved& check, double duration) {
  const double limit = parted * reference.displacement.cwiseAbs().maxCoeff();
  const Eigen::VectorXd difference = (check.displacement - reference.displacement).cwiseAbs();
  for (long i = 0; i < difference.size(); ++i) {
    if (difference(i) > limit)
      return duration * static_cast<double>(i) / static_cast<double>(difference.size());
  }
  return duration;
}

TradeoffChart chart_of(const SimulationProblem& problem, const std::string& quantity,
                       double reference_error) {
  TradeoffChart chart;
  chart.stage = "simulation";
  chart.problem = problem.name;
  chart.quantity = quantity;
  chart.reference = fmt::format(
      "modal method at a tolerance of {:g}; its error is its distance from a fixed step of {:g} s",
      reference_tolerance, reference_step);
  chart.reference_error = reference_error;
  return chart;
}

fem::Body rattling_body(const std::string& name, double from, double to, const fem::Section& section,
                        double density, double modulus, int elements) {
  fem::Body body{name, fem::straight_line({from, 0, 0}, {to, 0, 0}), section, density, 0.3, {}};
  body.elements = elements;
  body.material.youngs_modulus = fem::constant_law(modulus);
  body.material.rayleigh = {43.1, 2e-6};
  body.material.damping = fem::Damping::viscous;
  return body;
}

std::string law_name(fem::ContactLaw law) {
  switch (law) {
    case fem::ContactLaw::approach:
      return "approach law";
    case fem::ContactLaw::no_adhesion:
      return "no adhesion";
    case fem::ContactLaw::hunt_crossley:
      return "Hunt-Crossley law";
    case fem::ContactLaw::hard_stop:
      break;
  }
  return "hard stop";
}

fem::MotionHistory motion_of(const fem::Scene& scene) {
  const fem::Excitation& excitation = scene.simulation->excitation;
  if (excitation.kind != fem::Excitation::Kind::record) return fem::scene_motion(scene);
  const ident::Record record = ident::read_record(excitation.file, {excitation.column});
  return fem::motion_from_samples(record.samples.col(0), record.sample_interval);
}

}  // namespace

SimulationProblem rattling_wire_problem(fem::ContactLaw law) {
  fem::Scene scene;
  scene.bodies = {
      rattling_body("wire", 0.0, 0.501, {8.042477e-6, 3.1083e-12, 2 * 3.1083e-12}, 7650.0, 100e9, 25),
      rattling_body("band", 0.12, 0.441, {6.126106e-5, 3.9245e-10, 2 * 3.9245e-10}, 4535.0, 60e9, 16)};
  scene.drive = fem::SceneDrive{fem::Support{"wire", fem::End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement = fem::SceneMeasurement{fem::Support{"wire", fem::End::end},
                                            fem::MotionQuantity::displacement,
                                            {"force_y"},
                                            {Eigen::Vector3d::UnitY()}};
  scene.contacts = {{"wire", "band", 1.5e-4, 1e5, 100.0, law}};
  scene.simulation = fem::Simulation{};
  scene.simulation->duration = 0.1;
  scene.simulation->excitation.kind = fem::Excitation::Kind::chirp;
  scene.simulation->excitation.band_lo_hz = 100.0;
  scene.simulation->excitation.band_hi_hz = 1000.0;
  scene.simulation->excitation.acceleration = 60.0;
  const fem::MotionHistory motion = fem::scene_motion(scene);
  return {"rattling wire; " + law_name(law), scene, motion, scene.simulation->duration};
}

SimulationProblem scene_simulation_problem(const fem::Scene& scene, const std::string& name, double longest) {
  if (!scene.drive || !scene.measurement || !scene.simulation)
    throw Error("tradeoff: stage simulation needs [drive], [measure] and [simulation] in the scene");
  return {name, scene, motion_of(scene), std::min(longest, scene.simulation->duration)};
}

std::vector<TradeoffChart> tradeoff_simulation(const SimulationProblem& given, const TradeoffRun& run) {
  run.progress(fmt::format("simulation: {}, reference", given.name));
  const Timing once{1, 0.0};
  SimulationProblem problem = given;
  Solved reference = solve(problem, reference_way(), once);
  Solved check = solve(problem, check_way(), once);
  problem.duration = common_duration(reference, check, given.duration);
  const bool shorter = problem.duration < given.duration;
  if (shorter) {
    reference = solve(problem, reference_way(), once);
    check = solve(problem, check_way(), once);
  }
  TradeoffChart displacement = chart_of(problem, "displacement", displacement_error(check, reference));
  displacement.error_label = "largest error at the middle of the measured body over the largest displacement";
  TradeoffChart transfer = chart_of(problem, "transfer function", transfer_error(check, reference));
  transfer.error_label = "relative rms of the outputs' spectra over the band, at the same motion";
  std::vector<std::string> notes = {fmt::format("Compared over the first {:.3g} s.", problem.duration)};
  if (shorter)
    notes.push_back("There trajectories part: differences of rounding grow from impact to impact.");
  bool newmark = true;
  for (const Way& way : ways()) {
    if (way.method == fem::IntegrationMethod::newmark && !newmark) continue;
    const std::string knob = way.step > 0.0 ? "step [s]" : "tolerance [-]";
    const double value = way.step > 0.0 ? way.step : way.tolerance;
    run.progress(fmt::format("simulation: {}, {}, {:g}", problem.name, way.name, value));
    TradeoffRow row{way.name, knob, value};
    row.is_default =
        way.method == fem::Simulation{}.method && way.step == 0.0 && value == fem::Simulation{}.tolerance;
    try {
      const Solved solved = solve(problem, way, run.timing);
      row.seconds = solved.seconds;
      row.error = displacement_error(solved, reference);
      displacement.rows.push_back(row);
      row.error = transfer_error(solved, reference);
      transfer.rows.push_back(row);
    } catch (const Error& error) {
      if (way.method != fem::IntegrationMethod::newmark) throw;
      newmark = false;
      notes.push_back(fmt::format("Without newmark: {}", error.what()));
    }
  }
  displacement.notes = transfer.notes = notes;
  mark_pareto(displacement);
  mark_pareto(transfer);
  return {displacement, transfer};
}

std::vector<TradeoffChart> tradeoff_simulation(const TradeoffRun& run) {
  std::vector<TradeoffChart> charts = {wire_against_stop(0.2, run)};
  for (const auto law :
       {fem::ContactLaw::approach, fem::ContactLaw::no_adhesion, fem::ContactLaw::hunt_crossley}) {
    for (auto& chart : tradeoff_simulation(rattling_wire_problem(law), run))
      charts.push_back(std::move(chart));
  }
  return charts;
}

}  // namespace struna::apps
