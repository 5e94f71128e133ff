#include "apps/simulation_sizing.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/sizing.hpp"

namespace struna::apps {
namespace {

Level level_of(const fem::AccuracyTrial& trial, const fem::AccuracyTrial& chosen, const std::string& value) {
  return {value, trial.error, chosen.cost() > 0.0 ? trial.cost() / chosen.cost() : 0.0};
}

std::string modes_value(const fem::SimulationReport& report) {
  if (report.method == fem::IntegrationMethod::newmark) return "all";
  if (report.highest_mode_hz <= 0.0) return fmt::format("all {} that move", report.steps.modes);
  return fmt::format("{} stepped, {} above {:.4g} Hz follow statically", report.steps.modes,
                     report.steps.static_modes, report.highest_mode_hz);
}

Choice modes_choice(const fem::SimulationReport& report) {
  Choice choice{.what = "modes",
                .value = modes_value(report),
                .fixed = report.method == fem::IntegrationMethod::newmark || report.step > 0.0,
                .why = ""};
  if (report.method == fem::IntegrationMethod::newmark) {
    choice.why = "newmark steps all degrees of freedom";
  } else if (report.step > 0.0) {
    choice.why = "a fixed step takes every mode";
  } else if (report.accuracy) {
    choice.why = fmt::format(
        "tried from {:.3g} to {:.3g} s, around the first touch, against every mode at a tolerance of "
        "{:.1e}, its own error added",
        report.accuracy->checked_from, report.accuracy->checked_until, report.accuracy->reference.tolerance);
    choice.error = report.accuracy->estimated_error;
    choice.tolerance = report.tolerance;
    const fem::AccuracyTrial& chosen = report.accuracy->chosen;
    for (const fem::AccuracyTrial& trial : report.accuracy->less) {
      if (trial.highest_mode_hz == chosen.highest_mode_hz) continue;
      choice.less.push_back(
          level_of(trial, chosen, fmt::format("modes to {:.4g} Hz", trial.highest_mode_hz)));
    }
    choice.more = {level_of(report.accuracy->reference, chosen, "the reference, all modes and small steps")};
  } else if (!report.linear) {
    choice.why = "a run with every mode came near a gap and never touched: nothing to try";
  } else {
    const double share = report.highest_hz / report.highest_mode_hz;
    const auto error = [&](double factor) { return share * share / (factor * factor); };
    choice.why = "what modes above lack of their answer to the band is (f_band/f)^2";
    choice.error = error(1.0);
    choice.tolerance = report.tolerance * (1.0 + 1e-9);
    choice.less = {{fmt::format("to {:.4g} Hz", 0.5 * report.highest_mode_hz), error(0.5), 0.0}};
    choice.more = {{fmt::format("to {:.4g} Hz", 2.0 * report.highest_mode_hz), error(2.0), 0.0}};
  }
  return choice;
}

Choice steps_choice(const fem::Simulation& simulation, const fem::SimulationReport& report) {
  Choice choice{
      .what = "time step",
      .value = fmt::format("{:.3g} to {:.3g} s, {} steps", report.steps.shortest_step,
                           report.steps.longest_step, report.steps.free_steps + report.steps.contact_steps),
      .fixed = simulation.step > 0.0,
      .why = ""};
  if (choice.fixed) {
    choice.why = "the scene's own; its error is not estimated, leave it out to have it chosen";
  } else if (report.accuracy) {
    choice.why = "error of each step, tried together with the modes";
    choice.error = report.accuracy->estimated_error;
    choice.tolerance = report.tolerance;
    const fem::AccuracyTrial& chosen = report.accuracy->chosen;
    for (const fem::AccuracyTrial& trial : report.accuracy->less) {
      if (trial.tolerance == chosen.tolerance) continue;
      choice.less.push_back(level_of(trial, chosen, fmt::format("steps to {:.1e}", trial.tolerance)));
    }
  } else if (report.method == fem::IntegrationMethod::newmark) {
    choice.why = "period error (w dt)^2/12 at the band's end; at most 1e-5 s with contact";
    choice.error = fem::newmark_period_error(report.step, report.highest_hz);
    choice.tolerance = report.tolerance;
    choice.less = {{fmt::format("{:g} s", 2.0 * report.step), 4.0 * *choice.error, 0.5}};
    choice.more = {{fmt::format("{:g} s", 0.5 * report.step), 0.25 * *choice.error, 2.0}};
  } else {
    choice.why = "modes are stepped exactly; 40 steps per shortest period of the motion leave 1e-4 of it";
  }
  return choice;
}

void add_theory(const fem::Scene& scene, const fem::SimulationReport& report, std::vector<Choice>& choices) {
  for (const auto& body : report.bodies) {
    Choice theory = beam_theory_choice(fem::body_named(scene, body.name), report.highest_hz);
    const bool linear = body.largest_slope <= fem::largest_slope &&
                        body.stretch_stiffening <= fem::largest_stretch_stiffening &&
                        body.largest_bending_strain <= fem::largest_bending_strain;
    theory.value = linear ? "linear, holds" : "linear, OUTSIDE its range";
    theory.why += fmt::format(
        "; slope {:.2g} rad (small: {:g}), stretch stiffening {:.2g} ({:g}), bending strain {:.2g} "
        "({:g})",
        body.largest_slope, fem::largest_slope, body.stretch_stiffening, fem::largest_stretch_stiffening,
        body.largest_bending_strain, fem::largest_bending_strain);
    choices.push_back(theory);
  }
}

}  // namespace

std::string simulation_explanation(const fem::Scene& scene, const fem::SimulationReport& report) {
  const fem::Simulation& simulation = *scene.simulation;
  std::vector<Choice> choices;
  for (const auto& body : report.bodies) {
    fem::MeshRequest request{.hi_hz = report.highest_hz, .tolerance = simulation.tolerance};
    Choice mesh = mesh_choice(fem::body_named(scene, body.name), request, body.mesh);
    mesh.why += "; error of natural frequencies";
    choices.push_back(mesh);
  }
  choices.push_back(modes_choice(report));
  choices.push_back(steps_choice(simulation, report));
  choices.push_back({.what = "planes",
                     .value = report.steps.planar ? "one" : "space",
                     .why = fmt::format("{} modes idle: nothing drives them", report.steps.idle_modes)});
  std::string linear = "no contact in the scene";
  if (!scene.contacts.empty()) {
    linear = report.linear ? fmt::format("no gap closes in the linear solution, the nearest reaches {:.1f} %",
                                         100.0 * report.largest_offset)
                           : "the linear solution closes a gap";
  }
  choices.push_back({.what = "solution", .value = report.linear ? "linear" : "with contact", .why = linear});
  choices.push_back(
      {.what = "samples",
       .value = fmt::format("{:g} Hz, {} states each", simulation.sample_rate, report.oversampling),
       .fixed = true,
       .why = "sample_rate of the scene; contact is sampled at 40 kHz at least, then filtered"});
  add_theory(scene, report, choices);
  return explanation(
      fmt::format("sized for {:g} of the largest displacement, motion up to {:g} Hz; cost is steps times "
                  "modes",
                  simulation.tolerance, report.highest_hz),
      choices);
}

}  // namespace struna::apps
