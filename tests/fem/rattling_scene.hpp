#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fem/accuracy_choice.hpp"
#include "fem/error.hpp"
#include "fem/simulation_plan.hpp"
#include "tests/fem/random_scenes.hpp"

// Random wires that rattle in a tube, and what the choice of modes and steps is worth there.
namespace struna::fem::testing {

struct RattlingScene {
  Scene scene;
  MotionHistory motion;
  double tolerance = 0.0;
};

/// A straight or bent wire in a stiffer tube around its middle part, both clamped, the wire shaken at a
/// support so that it strikes the tube within some tenths of a second.
inline RattlingScene random_rattling_scene(unsigned seed) {
  Dice dice(1000 + seed);
  const double length = dice.uniform(0.3, 0.8);
  Body wire{
      .name = "wire", .centreline = straight_line({0, 0, 0}, {length, 0, 0}), .section = {}, .material = {}};
  Body tube = wire;
  tube.name = "tube";
  const bool bent = dice.chance(0.4);
  const double sag = dice.uniform(0.02, 0.1) * length;
  const auto along = [&](double from, double to) {
    if (!bent) return straight_line({from, 0, 0}, {to, 0, 0});
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i <= 8; ++i) {
      const double x = from + (to - from) * i / 8.0;
      points.emplace_back(x, 4.0 * sag * x * (length - x) / (length * length), 0.0);
    }
    return spline_through(points);
  };
  wire.centreline = along(0.0, length);
  tube.centreline = along(dice.uniform(0.1, 0.3) * length, dice.uniform(0.6, 0.9) * length);
  const double diameter = dice.uniform(0.002, 0.004);
  wire.section = solid_circle(diameter);
  tube.section = ring(3.0 * diameter, 1.2 * diameter);
  wire.density = 7650.0;
  tube.density = 4500.0;
  for (Body* body : {&wire, &tube}) {
    body->material.youngs_modulus = constant_law(dice.logarithmic(3e10, 2e11));
    body->material.rayleigh = {dice.uniform(5.0, 60.0), dice.logarithmic(5e-7, 5e-6)};
    body->material.damping = Damping::viscous;
  }
  Scene scene;
  scene.bodies = {wire, tube};
  scene.drive = SceneDrive{Support{"wire", End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement = SceneMeasurement{
      Support{"wire", End::end}, MotionQuantity::displacement, {"force_y"}, {Eigen::Vector3d::UnitY()}};
  const double gap = dice.logarithmic(5e-5, 4e-4);
  scene.contacts = {{"wire", "tube", gap, 1e5, dice.uniform(0.0, 100.0),
                     dice.chance(0.5) ? ContactLaw::approach : ContactLaw::no_adhesion}};
  scene.simulation = Simulation{};
  scene.simulation->duration = 0.3;
  scene.simulation->tolerance = dice.logarithmic(1e-4, 1e-2);
  Excitation& excitation = scene.simulation->excitation;
  excitation.kind = Excitation::Kind::random;
  excitation.band_lo_hz = 10.0;
  excitation.band_hi_hz = dice.logarithmic(200.0, 1000.0);
  excitation.rms_acceleration = dice.uniform(20.0, 60.0);
  excitation.seed = seed;
  const double tolerance = scene.simulation->tolerance;
  MotionHistory motion = motion_history(excitation, scene.simulation->duration);
  return {std::move(scene), std::move(motion), tolerance};
}

/// A plan with its bodies ready to be stepped.
struct PreparedRun {
  SimulationPlan plan;
  std::vector<ModalBody> bodies;
  std::vector<ContactPoint> points;
};

inline PreparedRun prepare(const RattlingScene& rattling, const Scene& scene) {
  PreparedRun run{plan_simulation(scene, rattling.motion.highest_hz()), {}, {}};
  for (const auto& body : run.plan.bodies) {
    run.bodies.push_back(
        modal_body(body.model, body.modes, body.coordinates, body.drive, rattling.motion.highest_hz()));
  }
  run.points = run.plan.points;
  return run;
}

/// Offsets of the contact points at the looks from `from` to `until`.
struct Path {
  std::vector<Eigen::Vector2d> offset;
  double largest = 0.0;
  double cost = 0.0;  ///< steps times modes
};

inline Path path_of(const PreparedRun& run, const RattlingScene& rattling,
                    const ModalSteppingOptions& options, double from, double until) {
  constexpr double interval = 2e-5;
  ModalStepper stepper(
      run.bodies, run.points, [&](double t) { return rattling.motion.at(t); }, options);
  Path path;
  const auto first = static_cast<long>(std::round(from / interval));
  const auto last = static_cast<long>(std::round(until / interval));
  for (long look = first; look <= last; ++look) {
    stepper.advance(static_cast<double>(look) * interval);
    for (std::size_t i = 0; i < run.points.size(); ++i)
      path.offset.push_back(stepper.offset(static_cast<int>(i)));
  }
  const StepReport& report = stepper.report();
  path.largest = report.largest_displacement;
  path.cost = static_cast<double>(report.free_steps + report.contact_steps) * report.modes;
  return path;
}

inline double deviation(const Path& path, const Path& reference) {
  double worst = 0.0;
  for (std::size_t i = 0; i < path.offset.size(); ++i)
    worst = std::max(worst, (path.offset[i] - reference.offset[i]).cwiseAbs().maxCoeff());
  return worst / reference.largest;
}

struct SizedRun {
  double error = 0.0;            ///< over the tolerance
  double cost = 0.0;             ///< over that of the cheapest setting of the grid that meets the tolerance
  double reference_error = 0.0;  ///< over the tolerance
  double mesh_error = 0.0;       ///< of the reference's mesh against twice the elements, over the tolerance
  AccuracyChoice choice;
};

/// The scene on meshes of `factor` times the elements of `coarse`, contact points only where `coarse` has
/// them.
inline PreparedRun refined(const RattlingScene& rattling, const PreparedRun& coarse, int factor,
                           Scene& scene) {
  scene = rattling.scene;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    scene.bodies[b].elements = factor * coarse.plan.bodies[b].mesh.elements;
  PreparedRun run = prepare(rattling, scene);
  std::vector<ContactPoint> kept;
  for (std::size_t i = 0; i < run.plan.pairs.size(); ++i) {
    const bool shared = std::any_of(
        coarse.plan.pairs.begin(), coarse.plan.pairs.end(),
        [&](const JoinedPair& pair) { return factor * pair.pair.node == run.plan.pairs[i].pair.node; });
    if (shared) kept.push_back(run.points[i]);
  }
  run.points = kept;
  return run;
}

inline SizedRun size_run(const RattlingScene& rattling, bool with_cost = true) {
  SizedRun sized;
  const PreparedRun run = prepare(rattling, rattling.scene);
  ModalSteppingOptions options;
  options.tolerance = rattling.tolerance;
  options.keep_events = false;
  sized.choice = choose_accuracy(
      run.bodies, run.points, [&](double t) { return rattling.motion.at(t); },
      first_cut_hz(rattling.motion.highest_hz(), rattling.tolerance, true),
      rattling.scene.simulation->duration, options, false);
  const double from = sized.choice.checked_from, until = sized.choice.checked_until;
  options.tolerance = 0.05 * rattling.tolerance;
  const Path reference = path_of(run, rattling, options, from, until);
  options.tolerance = 0.15 * rattling.tolerance;
  sized.reference_error =
      deviation(path_of(run, rattling, options, from, until), reference) / rattling.tolerance;
  const auto tried = [&](double tolerance, double highest_mode_hz) {
    options.tolerance = tolerance;
    options.highest_mode_hz = highest_mode_hz;
    return path_of(run, rattling, options, from, until);
  };
  const Path chosen = tried(sized.choice.tolerance, sized.choice.highest_mode_hz);
  sized.error = deviation(chosen, reference) / rattling.tolerance;
  sized.cost = 1.0;
  if (!with_cost) return sized;
  Scene finer_scene;
  const PreparedRun finer = refined(rattling, run, 2, finer_scene);
  options.tolerance = 0.25 * rattling.tolerance;
  options.highest_mode_hz = 0.0;
  sized.mesh_error =
      deviation(path_of(finer, rattling, options, from, until), reference) / rattling.tolerance;
  double cheapest = sized.error <= 1.0 ? chosen.cost : std::numeric_limits<double>::infinity();
  const double limit = static_mode_limit(rattling.motion.highest_hz(), rattling.tolerance);
  for (const double tolerance : {0.25, 1.0, 4.0, 16.0}) {
    for (const double cut : {0.25, 0.5, 1.0, 2.0, 4.0, 0.0}) {
      try {
        const Path path = tried(std::min(0.5, tolerance * rattling.tolerance), cut * limit);
        if (deviation(path, reference) <= rattling.tolerance) cheapest = std::min(cheapest, path.cost);
      } catch (const Error&) {
        continue;  // contacts that do not converge with so few modes
      }
    }
  }
  sized.cost = chosen.cost / cheapest;
  return sized;
}

}  // namespace struna::fem::testing
