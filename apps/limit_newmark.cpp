#include "apps/limit_newmark.hpp"

#include <numbers>

#include "fem/simulation.hpp"

namespace struna::apps {
namespace {

constexpr double highest_hz = 300.0;
constexpr double force_tolerance = 0.05;  ///< stated in docs/limits.md

fem::Scene shaken_wire(double damping_ratio, double duration) {
  fem::Body wire{"wire", fem::straight_line({0, 0, 0}, {0.68, 0, 0}), fem::solid_circle(0.0032), 7650.0, 0.3,
                 {}};
  wire.material.youngs_modulus = fem::constant_law(120e9);
  wire.material.rayleigh = {0.0, 2.0 * damping_ratio / (2.0 * std::numbers::pi * highest_hz)};
  wire.material.damping = fem::Damping::viscous;
  wire.elements = 16;
  fem::Scene scene;
  scene.bodies = {wire};
  scene.drive = fem::SceneDrive{fem::Support{"wire", fem::End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement = fem::SceneMeasurement{fem::Support{"wire", fem::End::end},
                                            fem::MotionQuantity::displacement,
                                            {"force_y"},
                                            {Eigen::Vector3d::UnitY()}};
  fem::Simulation simulation;
  simulation.duration = duration;
  simulation.sample_rate = 2000.0;
  simulation.excitation.kind = fem::Excitation::Kind::random;
  simulation.excitation.band_lo_hz = 10.0;
  simulation.excitation.band_hi_hz = highest_hz;
  simulation.excitation.rms_acceleration = 1.0;
  scene.simulation = simulation;
  return scene;
}

}  // namespace

LimitMap newmark_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "newmark";
  map.title = "Newmark stepping: a wire shaken up to 300 Hz";
  map.quantity = "force at the far support (rms over rms)";
  map.fails =
      "vibrations come out too slow by (w dt)^2/12 and drift out of phase, the more the less they are damped";
  map.sign = "what the scheme makes of the modes up to twice the band's end under this motion";
  map.then = "warns and names the step that would do";
  map.axes = {run.axis("steps per period", {4, 8, 16, 32, 64, 128, 256}),
              run.axis("damping ratio [%]", {0.03, 0.1, 0.3, 1, 3, 10}), run.axis("duration [s]", {0.2, 1})};
  for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& place) {
    for (const unsigned seed : run.draws(3)) {
      fem::Scene scene = shaken_wire(0.01 * place[0], place[1]);
      scene.simulation->excitation.seed = seed;
      scene.simulation->tolerance = 1e-6;
      const fem::MotionHistory motion = fem::scene_motion(scene);
      const Eigen::VectorXd reference = fem::simulate(scene, motion).output.col(0);
      scene.simulation->method = fem::IntegrationMethod::newmark;
      for (const double steps : map.axes[0].values) {
        scene.simulation->step = 1.0 / (steps * highest_hz);
        const fem::TimeResponse response = fem::simulate(scene, motion);
        LimitTrial trial;
        trial.at = {steps, place[0], place[1]};
        trial.seed = seed;
        trial.error = (response.output.col(0) - reference).norm() / reference.norm();
        trial.tolerance = force_tolerance;
        if (told(response.report.warnings, "newmark's step")) trial.flags = "step";
        map.trials.push_back(std::move(trial));
      }
    }
  });
  return map;
}

}  // namespace struna::apps
