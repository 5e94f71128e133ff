#include "fem/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/accuracy_choice.hpp"
#include "fem/causal_distance.hpp"
#include "fem/error.hpp"
#include "fem/newmark_error.hpp"
#include "fem/sampled_run.hpp"
#include "fem/scene_stepper.hpp"
#include "fem/step_check.hpp"

namespace struna::fem {
namespace {

/// Keeps what is to be told, each once, and passes it on at once.
class Warner {
 public:
  Warner(std::vector<std::string>& kept, const SimulationWarning& tell) : kept_(kept), tell_(tell) {}
  void operator()(const std::string& warning) const {
    if (warning.empty() || std::find(kept_.begin(), kept_.end(), warning) != kept_.end()) return;
    kept_.push_back(warning);
    if (tell_) tell_(warning);
  }

 private:
  std::vector<std::string>& kept_;
  const SimulationWarning& tell_;
};

/// What a run is given besides the scene.
struct RunContext {
  const Scene& scene;
  SimulationPlan& plan;
  const MotionHistory& motion;
  const SimulationProgress& progress;
  const Warner& warn;
  TimeResponse& response;
  bool levels;  ///< the accuracy report tells coarser settings too
};

/// Gravity, or bodies that press on each other as drawn: the run starts from the static rest.
bool starts_settled(const Scene& scene, const SimulationPlan& plan, bool contact) {
  return !scene.simulation->gravity.isZero(0.0) || (contact && plan.overlap > 0.0);
}

/// States sampled per second in front of the anti-alias filter, with contact [Hz]. From 10 to 80 kHz the
/// half-octave levels of a 5 kHz record change by less than 0.01 dB (docs/simulation.md).
constexpr double contact_sampling_hz = 40000.0;
constexpr double noticed = 0.05;  ///< error of a step that no tolerance chose

/// The most states per record sample: beyond 64 only as many as the motion's own band needs.
double largest_oversampling(double rate, double highest_hz) {
  return std::max(64.0, std::ceil(2.5 * highest_hz / rate));
}

/// Whether the motion holds frequencies that records at this rate cannot.
bool exceeds_records(const Simulation& simulation, double highest_hz) {
  return highest_hz > 0.5 * simulation.sample_rate * (1.0 + 1e-9);
}

/// Contact makes frequencies of every height, and a record may hold more than its copy at a lower rate can:
/// then more states than samples are looked at, `wanted_rate` a second, and filtered.
Sampling sampling_of(const Simulation& simulation, double highest_hz, double wanted_rate, bool contact) {
  Sampling sampling;
  sampling.rate = simulation.sample_rate;
  sampling.samples = sample_intervals(simulation);
  sampling.filter_motion = exceeds_records(simulation, highest_hz);
  sampling.filter = contact || sampling.filter_motion;
  sampling.oversampling = static_cast<int>(std::clamp(std::ceil(wanted_rate / sampling.rate), 1.0,
                                                      largest_oversampling(sampling.rate, highest_hz)));
  if (sampling.samples < 1) {
    throw Error(fmt::format("simulate: the duration {:g} s is shorter than a sample at {:g} Hz",
                            simulation.duration, sampling.rate));
  }
  return sampling;
}

/// What the filter takes out of the band that drives the scene.
void warn_of_filter(const RunContext& run, const Sampling& sampling, bool contact) {
  const Simulation& simulation = *run.scene.simulation;
  const double highest_hz = run.motion.highest_hz();
  const bool filtered = sampling.filter && sampling.oversampling > 1;
  if (!filtered && (contact || exceeds_records(simulation, highest_hz))) {
    run.warn(
        fmt::format("the step of {:g} s is as long as a sample of the records: frequencies above {:g} "
                    "Hz fold into them; a step of {:.2g} s would keep them out",
                    run.response.report.step, 0.5 * simulation.sample_rate, 0.25 / simulation.sample_rate));
  }
  const double usable = 0.4 * simulation.sample_rate;
  const bool record = simulation.excitation.kind == Excitation::Kind::record;
  // A record at the rate of the records written is as full as theirs can be.
  if (!filtered || highest_hz <= usable || (record && !exceeds_records(simulation, highest_hz))) return;
  run.warn(
      fmt::format("the anti-alias filter passes {:g} Hz, less than the {:g} Hz that the motion reaches; "
                  "a sample_rate of {:g} Hz would hold it",
                  usable, highest_hz, 2.5 * highest_hz));
}

/// What the trials found, told where no tolerance says what matters. False: stopped by the user.
bool take_over(const StepCheck& check, const RunContext& run) {
  SimulationReport& report = run.response.report;
  report.estimated_error = check.estimated_error;
  report.error_checked_until = check.checked_until;
  if (report.estimated_error > noticed) {
    run.warn(fmt::format(
        "the step of {:.3g} s is too long for the contacts: up to {:.3g} s, soon after the first touch, the "
        "estimated error is {:.2g} of the largest displacement; a shorter step, or the modal method to a "
        "tolerance, would follow them",
        report.step, report.error_checked_until, report.estimated_error));
  } else if (report.tolerance > 0.0 && report.estimated_error > report.tolerance) {
    run.warn(fmt::format(
        "the tolerance of {:g} is not met: at newmark's step of {:.3g} s the error estimated up to "
        "{:.3g} s, soon after the first touch, is {:.2g} of the largest displacement; the modal "
        "method chooses its steps by it",
        report.tolerance, report.step, report.error_checked_until, report.estimated_error));
  }
  return !check.interrupted;
}

/// As far as the motion is known [s]: the last sample of a record lies an interval before the duration.
double run_duration(const RunContext& run) {
  return std::min(run.scene.simulation->duration, run.motion.duration());
}

/// Whether its first part excites what the rest does.
bool is_steady(const Excitation& excitation) {
  using enum Excitation::Kind;
  return excitation.kind == sine || excitation.kind == random || excitation.kind == multisine;
}

/// A contact that swings faster than its steps, of `part` [s] in contact, rebounds as the steps have it, not
/// as the law has. `radians`: of the swing, that a step may take.
void warn_of_step(const RunContext& run, double part, int substeps, double radians, const char* cure) {
  const double rate = run.plan.fastest_contact;
  if (rate * part <= radians) return;
  run.warn(fmt::format(
      "in contact the step of {:.2g} s is long against the contact spring's period of {:.2g} s: blows are "
      "not resolved; a step of {:.1g} s would, or {}",
      part, 2.0 * std::numbers::pi / rate, radians / rate * substeps, cure));
}

/// Modes and steps from the tolerance, told in the report. With a fixed step every mode is stepped. False:
/// stopped by the user.
bool set_accuracy(const RunContext& run, const std::vector<ModalBody>& bodies, bool contact,
                  const Sampling& sampling, ModalSteppingOptions& options) {
  SimulationReport& report = run.response.report;
  const MotionHistory& motion = run.motion;
  const double duration = run_duration(run);
  const auto at = [motion](double t) { return motion.at(t); };
  const bool settled = starts_settled(run.scene, run.plan, contact);
  if (options.step > 0.0) {
    if (!contact) return true;
    // Touch is located and energy kept: three steps a period serve, fewer agree with finer ones by chance.
    const double interval = sampling.interval();
    const double part = std::min(options.step / options.contact_substeps, interval);
    warn_of_step(run, part, options.contact_substeps, 2.0, "a tolerance instead");
    // Steps end at every state looked at, so that a longer one asked for is none: a quarter is of that taken.
    ModalSteppingOptions taken = options;
    taken.step = part * options.contact_substeps;
    return take_over(
        check_step(bodies, run.plan.points, at, duration, taken, settled, run.progress, interval), run);
  }
  if (!contact) {
    options.highest_mode_hz = static_mode_limit(motion.highest_hz(), options.tolerance);
    report.highest_mode_hz = options.highest_mode_hz;
    return true;
  }
  const AccuracyChoice choice = choose_accuracy(
      bodies, run.plan.points, at,
      first_cut_hz(motion.highest_hz(), options.tolerance, is_steady(run.scene.simulation->excitation)),
      duration, options, settled, run.progress, run.levels, sampling.interval());
  if (choice.interrupted) return false;
  options.highest_mode_hz = choice.highest_mode_hz;
  options.tolerance = choice.tolerance;
  report.highest_mode_hz = choice.highest_mode_hz;
  report.estimated_error = choice.estimated_error;
  report.error_checked_until = choice.checked_until;
  if (report.estimated_error > report.tolerance) {
    run.warn(fmt::format(
        "the tolerance of {:g} is not met: trajectories part quickly here; they are known to it up to {:.4g} "
        "s, and up to {:.3g} s, soon after the first touch, to {:.2g} of the largest displacement; beyond, "
        "trust levels and spectra, and no instant",
        report.tolerance, choice.known_until, report.error_checked_until, report.estimated_error));
  }
  if (choice.checked_until > 0.0) report.accuracy = choice;
  return true;
}

/// The causal law against the loss factors that it stands for, over the band that drives the scene.
void judge_causal_law(const RunContext& run, const ModalBody& body) {
  const Excitation& excitation = run.scene.simulation->excitation;
  const double hi = run.motion.highest_hz();
  const double lo = excitation.kind == Excitation::Kind::sine ? hi
                    : excitation.band_lo_hz > 0.0             ? excitation.band_lo_hz
                                                              : 0.01 * hi;
  const Model& model = run.plan.bodies[static_cast<std::size_t>(run.plan.measured_body)].model;
  auto& distance = run.response.report.causal_distance;
  distance = causal_distance(run.scene, model, body, run.plan.rows, lo, hi);
  constexpr double far = 0.05;
  if (!distance || *distance <= far) return;
  run.warn(fmt::format(
      "E(f) and the loss factor of '{}' belong to no causal material: in time it answers {:.2g} % (rms over "
      "the band, without contact) off its harmonic response; compare predictions with that in mind",
      model.body.name, 100.0 * *distance));
}

RunEnd run_modal(const RunContext& context, bool contact) {
  const auto& [scene, plan, motion, progress, warn, response, levels] = context;
  const Simulation& simulation = *scene.simulation;
  std::vector<ModalBody> bodies;
  for (const auto& body : plan.bodies) {
    bodies.push_back(modal_body(body.model, body.modes, body.coordinates, body.drive, motion.highest_hz()));
  }
  ModalSteppingOptions options;
  options.tolerance = simulation.tolerance;
  options.step = simulation.step;
  options.contact_substeps = simulation.contact_substeps.value_or(options.contact_substeps);
  options.keep_events = false;
  // The load enters a step by two moments. At 40 steps per shortest period what they miss is below 1e-4 of a
  // line; with contact the sampling keeps steps short enough.
  if (!contact) options.longest_step = 1.0 / (40.0 * motion.highest_hz());
  const MaxwellLaw law = bodies[static_cast<std::size_t>(plan.measured_body)].poles.law;
  const bool looks = contact || !plan.points.empty() || exceeds_records(simulation, motion.highest_hz());
  const double wanted = contact ? std::max(4.0 * simulation.sample_rate, contact_sampling_hz)
                                : checks_per_period * motion.highest_hz();
  const Sampling sampling = sampling_of(simulation, motion.highest_hz(), looks ? wanted : 0.0, contact);
  if (!contact) judge_causal_law(context, bodies[static_cast<std::size_t>(plan.measured_body)]);
  if (contact) warn_of_filter(context, sampling, contact);
  if (!set_accuracy(context, bodies, contact, sampling, options)) return RunEnd::interrupted;
  const auto stepper =
      modal_run(plan, std::move(bodies), contact, motion, options, starts_settled(scene, plan, contact));
  const RunEnd end = run(*stepper, plan, law, motion, sampling, contact, progress, response);
  if (!contact && end != RunEnd::gap_closed) warn_of_filter(context, sampling, contact);
  return end;
}

/// Newmark's body and the modulus law of its reaction. Throws Error where its material is more than E, alpha
/// and beta.
std::pair<NodalBody, MaxwellLaw> newmark_body(const PlannedBody& planned) {
  const Material& material = planned.model.body.material;
  const bool elastic = material.damping == Damping::structural &&
                       material.loss_factor.kind == FrequencyLaw::Kind::constant &&
                       material.loss_factor.at(1.0) == 0.0;
  if (material.youngs_modulus.kind != FrequencyLaw::Kind::constant ||
      (material.damping == Damping::structural && !elastic)) {
    throw Error(fmt::format(
        "simulate: method \"newmark\" needs a constant youngs_modulus and Rayleigh damping (damping = "
        "\"viscous\") in body '{}'; method \"modal\" takes E(f) and loss factors into the time domain",
        planned.model.body.name));
  }
  const Rayleigh rayleigh = elastic ? Rayleigh{} : material.rayleigh;
  const double modulus = material.youngs_modulus.at(1.0);
  NodalBody body = nodal_body(planned.model, modulus, rayleigh, planned.drive.moved, planned.drive.direction);
  const auto& free = planned.model.free_dof;
  if (planned.drive.force.size() > 0) body.load.col(0) += planned.drive.force(free);
  if (!planned.drive.gravity.isZero(0.0))
    body.constant_load = gravity_load(planned.model, planned.drive.gravity)(free);
  return {body, MaxwellLaw{modulus, {}, {}, rayleigh.beta * modulus}};
}

/// Step [s] whose newmark_period_error() at the band's edge meets the tolerance, at most 1e-5 s where contact
/// has to be followed.
double newmark_step(const Simulation& simulation, double highest_hz, bool contact) {
  if (simulation.step > 0.0) return simulation.step;
  const double step = std::sqrt(simulation.tolerance / newmark_period_error(1.0, highest_hz));
  return contact ? std::min(step, 1e-5) : step;
}

/// newmark_error() of the bodies; the worst.
double drift_of(const RunContext& run, const NewmarkOptions& options) {
  const MotionHistory& motion = run.motion;
  const double highest_hz = motion.highest_hz();
  const double duration = run_duration(run);
  double worst = 0.0;
  for (const auto& [mesh, model, modes, drive, coordinates] : run.plan.bodies) {
    const Material& material = model.body.material;
    const Rayleigh rayleigh = material.damping == Damping::viscous ? material.rayleigh : Rayleigh{};
    const auto body = modal_body(model, modes, modal_coordinates(model, modes, drive), drive, highest_hz);
    const auto at = [&](double t) { return motion.at(t); };
    worst = std::max(worst, newmark_error(options, body, rayleigh, at, highest_hz, duration));
  }
  return worst;
}

/// What a user should know of Newmark's step.
void warn_of_drift(const RunContext& run, const NewmarkOptions& options) {
  const double highest_hz = run.motion.highest_hz(), drift = drift_of(run, options);
  if (!(drift > noticed)) return;
  run.warn(fmt::format(
      "newmark's step of {:.3g} s makes vibrations at {:g} Hz too slow by {:.2g} %, which puts some {:.0f} % "
      "of the response in error as they ring; a step of {:.2g} s would leave 5 %, the modal method none",
      options.step, highest_hz, 100.0 * newmark_period_error(options.step, highest_hz),
      std::min(100.0, 100.0 * drift), options.step * std::sqrt(noticed / drift)));
}

RunEnd run_newmark(const RunContext& context, bool contact) {
  const auto& [scene, plan, motion, progress, warn, response, levels] = context;
  const Simulation& simulation = *scene.simulation;
  std::vector<NodalBody> bodies;
  MaxwellLaw law;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    auto [body, modulus] = newmark_body(plan.bodies[b]);
    bodies.push_back(std::move(body));
    if (static_cast<int>(b) == plan.measured_body) law = modulus;
  }
  NewmarkOptions options;
  options.step = newmark_step(simulation, motion.highest_hz(), contact);
  options.contact_substeps = simulation.contact_substeps.value_or(options.contact_substeps);
  // Sampled at whole steps: the step is shortened a little, so that a whole number of them lies between
  // record samples.
  Sampling sampling = sampling_of(simulation, motion.highest_hz(), 0.0, contact);
  const double per_sample = std::ceil(1.0 / (sampling.rate * options.step) - 1e-9);
  const double wanted = contact ? 4.0 * sampling.rate : checks_per_period * motion.highest_hz();
  for (int k = 1; k <= static_cast<int>(per_sample) && sampling.oversampling * sampling.rate < wanted; ++k) {
    if (static_cast<int>(per_sample) % k == 0) sampling.oversampling = k;
  }
  options.step = 1.0 / (sampling.rate * per_sample);
  sampling.filter = sampling.filter && sampling.oversampling > 1;
  sampling.filter_motion = sampling.filter_motion && sampling.filter;
  response.report.step = options.step;
  const bool settled = starts_settled(scene, plan, contact);
  if (contact) {
    warn_of_step(context, options.step / options.contact_substeps, options.contact_substeps, 0.5,
                 "method \"modal\", which locates them");
    warn_of_drift(context, options);
    warn_of_filter(context, sampling, contact);
    const double duration = run_duration(context);
    const auto at = [motion](double t) { return motion.at(t); };
    const auto check =
        check_step(bodies, plan.points, at, duration, options, settled, progress, sampling.interval());
    if (!take_over(check, context)) return RunEnd::interrupted;
  }
  const auto stepper = newmark_run(plan, std::move(bodies), contact, motion, options, settled);
  const RunEnd end = run(*stepper, plan, law, motion, sampling, contact, progress, response);
  if (!contact && end != RunEnd::gap_closed) {
    warn_of_drift(context, options);
    warn_of_filter(context, sampling, contact);
  }
  return end;
}

/// What only the finished run tells.
void warn_of_result(const RunContext& run) {
  const SimulationReport& report = run.response.report;
  for (const auto& body : report.bodies) {
    if (body.stretch_stiffening > largest_stretch_stiffening) {
      run.warn(fmt::format(
          "outside linear beam theory: the deflection of '{}' would stretch it so that its first natural "
          "frequency squared rises by some {:.0f} %; the linear model leaves that out",
          body.name, 100.0 * body.stretch_stiffening));
    }
    if (body.largest_slope > largest_slope) {
      run.warn(fmt::format("outside linear beam theory: '{}' turns by {:.2f} rad (small is below {:g})",
                           body.name, body.largest_slope, largest_slope));
    }
    if (body.largest_bending_strain > largest_bending_strain) {
      run.warn(fmt::format("outside linear beam theory: bending strains '{}' by {:.2g} (small is below {:g})",
                           body.name, body.largest_bending_strain, largest_bending_strain));
    }
  }
  // A push at the start rings for a while; what it presses in says nothing of the wall.
  const bool pushed = report.start_penetration > 0.0 && !starts_settled(run.scene, run.plan, true);
  constexpr double ringing = 0.05;  // [s]
  if (pushed) {
    run.warn(
        fmt::format("the motion does not start at rest: its first value takes the body {:.3g} m through a "
                    "gap, and the run "
                    "begins with a push; start the motion at zero, or leave out the first {:g} s",
                    report.start_penetration, ringing));
  }
  for (const auto& map : run.response.contacts) {
    const long skipped =
        pushed ? std::min(std::lround(std::ceil(ringing / map.interval)), map.penetration.rows() / 2) : 0L;
    const long bins = map.penetration.rows() - skipped;
    const double deepest =
        bins > 0 && map.penetration.cols() > 0 ? map.penetration.bottomRows(bins).maxCoeff() : 0.0;
    constexpr double soft = 0.44;  // of the gap: displacements are then a quarter off those at a rigid wall
    if (deepest > soft * map.gap) {
      run.warn(
          fmt::format("'{}' presses {:.3g} m into '{}', {:.0f} % of the gap of {:g} m: the contact stiffness "
                      "is too low to stand for a wall; a higher one would, or law = \"hard_stop\"",
                      map.inside, deepest, map.outside, 100.0 * deepest / map.gap, map.gap));
    }
  }
}

}  // namespace

long sample_intervals(const Simulation& simulation) {
  return static_cast<long>(std::floor(simulation.duration * simulation.sample_rate + 1e-6));
}

double newmark_period_error(double step, double f_hz) {
  const double angle = 2.0 * std::numbers::pi * f_hz * step;
  return angle * angle / 12.0;
}

MotionHistory scene_motion(const Scene& scene) {
  if (!scene.simulation) throw Error("simulate: the scene needs a [simulation] with duration and excitation");
  const bool force = scene.drive && std::holds_alternative<BodyPoint>(scene.drive->at);
  if (force) {
    throw Error(
        "simulate: a drive at a point is a force, and only a record can describe one; give excitation kind "
        "\"record\" with a column of force");
  }
  return motion_history(scene.simulation->excitation, scene.simulation->duration);
}

TimeResponse simulate(const Scene& scene, const MotionHistory& motion, const SimulationProgress& progress,
                      const SimulationWarning& tell, bool levels) {
  SimulationPlan plan = plan_simulation(scene, motion.highest_hz());
  const Simulation& simulation = *scene.simulation;
  if (motion.duration() < simulation.duration - 1.0 / simulation.sample_rate) {
    throw Error(fmt::format("simulate: the motion lasts {:g} s, less than the duration of {:g} s",
                            motion.duration(), simulation.duration));
  }
  const bool modal = simulation.method == IntegrationMethod::modal;
  const auto run_method = modal ? run_modal : run_newmark;
  TimeResponse response;
  response.report.method = simulation.method;
  response.report.highest_hz = motion.highest_hz();
  response.report.tolerance = simulation.step > 0.0 ? 0.0 : simulation.tolerance;
  response.report.step = simulation.step;
  response.names = scene.measurement->names;
  const Warner warn(response.report.warnings, tell);
  const RunContext run{scene, plan, motion, progress, warn, response, levels};
  warn(motion.note());
  for (const std::string& warning : plan.warnings) warn(warning);
  if (modal && simulation.contact_substeps && simulation.step == 0.0) {
    warn(
        "contact_substeps does nothing here: the steps in contact follow from the tolerance; give it with "
        "step, or leave it out");
  }
  // The linear solution first: where it stays clear of every gap, contact changes nothing.
  RunEnd end = run_method(run, false);
  response.report.linear = end != RunEnd::gap_closed;
  // Interrupted before the first step, the linear part up to the first touch stays.
  if (end == RunEnd::gap_closed) {
    end = run_method(run, true);
  }
  response.report.complete = end == RunEnd::complete;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    response.report.bodies[b].name = plan.bodies[b].model.body.name;
    response.report.bodies[b].mesh = plan.bodies[b].mesh;
    response.report.bodies[b].elements = static_cast<int>(plan.bodies[b].model.arc_length.size()) - 1;
  }
  warn_of_result(run);
  return response;
}

}  // namespace struna::fem
