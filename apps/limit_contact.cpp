#include "apps/limit_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "apps/tradeoff_simulation.hpp"
#include "fem/error.hpp"
#include "fem/simulation.hpp"
#include "fem/simulation_plan.hpp"

namespace struna::apps {
namespace {

constexpr double displacement_tolerance = 0.05;  ///< stated in docs/limits.md
constexpr double duration = 0.03;                ///< [s]
constexpr long most_steps = 1000000;             ///< of a run over that: more do not end in a user's time
constexpr double infinite = std::numeric_limits<double>::infinity();

fem::Scene rattling_scene(double stiffness, double damping, unsigned seed) {
  fem::Scene scene = rattling_wire_problem(fem::ContactLaw::approach).scene;
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform;
  scene.bodies[0].elements = 16;
  scene.bodies[1].elements = 10;
  scene.contacts[0].stiffness = stiffness;
  scene.contacts[0].damping = damping;
  scene.measurement = fem::SceneMeasurement{fem::BodyPoint{"wire", 0.5},
                                            fem::MotionQuantity::displacement,
                                            {"displacement"},
                                            {scene.drive->direction}};
  fem::Simulation& simulation = *scene.simulation;
  simulation.duration = duration;
  simulation.excitation = {};
  simulation.excitation.kind = fem::Excitation::Kind::sine;
  simulation.excitation.frequency_hz = 60.0 + 200.0 * uniform(engine);
  simulation.excitation.acceleration = 60.0 + 200.0 * uniform(engine);
  return scene;
}

/// Distances |h| of the possible contact points (samples x points), whether the program warned of steps,
/// and for how many samples it claims to know.
struct Run {
  Eigen::MatrixXd path;
  bool warned = false;
  long checked = 0;
};

/// Throws Error where the program refuses, or takes more steps than a user could wait for.
Run run_of(const fem::Scene& scene, const fem::MotionHistory& motion) {
  const fem::TimeResponse response = fem::simulate(scene, motion);
  const fem::StepReport& steps = response.report.steps;
  Run run;
  if (response.contacts.empty()) return run;
  // Every state has its own time bin; those at the record's samples are common to all methods.
  const fem::ContactMap& map = response.contacts[0];
  const long stride = response.report.oversampling;
  run.path.resize((map.penetration.rows() - 1) / stride + 1, map.penetration.cols());
  for (long i = 0; i < run.path.rows(); ++i)
    run.path.row(i) = map.penetration.row(i * stride).array() + map.gap;
  if (steps.free_steps + steps.contact_steps + steps.rejected_steps > most_steps)
    run.path.setConstant(infinite);
  const auto& warnings = response.report.warnings;
  run.warned = told(warnings, "too long for the contacts") || told(warnings, "is not met") ||
               told(warnings, "blows are not resolved");
  run.checked = static_cast<long>(response.report.error_checked_until / response.sample_interval);
  return run;
}

/// The same distances by the modal stepper itself with every mode, whatever the program says of the scene.
/// Nothing where it fails, or takes too many steps.
std::optional<Eigen::MatrixXd> modal_path(fem::Scene scene, const fem::MotionHistory& motion,
                                          const fem::ModalSteppingOptions& options) {
  const double stiffness = scene.contacts[0].stiffness;
  scene.contacts[0].stiffness = 1e5;  // a plan refuses rigid ones
  scene.simulation->method = fem::IntegrationMethod::modal;
  fem::SimulationPlan plan = fem::plan_simulation(scene, motion.highest_hz());
  std::vector<fem::ModalBody> bodies;
  for (const auto& body : plan.bodies)
    bodies.push_back(modal_body(body.model, body.modes, body.coordinates, body.drive, motion.highest_hz()));
  for (auto& point : plan.points) point.law.stiffness = stiffness;
  try {
    fem::ModalStepper stepper(
        std::move(bodies), plan.points, [&](double t) { return motion.at(t); }, options);
    Eigen::MatrixXd path(fem::sample_intervals(*scene.simulation) + 1, plan.points.size());
    for (long i = 0; i < path.rows(); ++i) {
      stepper.advance(static_cast<double>(i) / scene.simulation->sample_rate);
      for (long k = 0; k < path.cols(); ++k)
        path(i, k) = stepper.penetration(static_cast<int>(k)) + scene.contacts[0].gap;
      const fem::StepReport& steps = stepper.report();
      if (steps.free_steps + steps.contact_steps + steps.rejected_steps > most_steps) return std::nullopt;
    }
    return path;
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// The path at a tolerance and at a tenth of it. What parts from either is wrong: where the two part
/// themselves, nobody knows the path.
using Truth = std::array<Eigen::MatrixXd, 2>;

std::optional<Truth> truth_of(const fem::Scene& scene, const fem::MotionHistory& motion, double tolerance) {
  fem::ModalSteppingOptions options;
  options.keep_events = false;
  options.tolerance = tolerance;
  const auto rough = modal_path(scene, motion, options);
  options.tolerance = 0.1 * tolerance;
  const auto fine = modal_path(scene, motion, options);
  if (!rough || !fine) return std::nullopt;
  return Truth{*fine, *rough};
}

/// Largest error over the largest distance in the first rows; nothing where there are none.
std::optional<double> error_of(const Eigen::MatrixXd& path, long rows, const Truth& truth) {
  const long n = std::min({rows, path.rows(), truth[0].rows()});
  if (n < 2) return std::nullopt;
  double worst = 0.0;
  for (const auto& known : truth)
    worst = std::max(worst, (path.topRows(n) - known.topRows(n)).cwiseAbs().maxCoeff());
  return worst / truth[0].topRows(n).cwiseAbs().maxCoeff();
}

/// One run of the program against the truth; nothing where nothing touched.
std::optional<LimitTrial> trial_of(const fem::Scene& scene, const fem::MotionHistory& motion,
                                   const std::optional<Truth>& truth, double tolerance) {
  LimitTrial trial;
  trial.tolerance = tolerance;
  try {
    const Run run = run_of(scene, motion);
    const auto error = truth ? error_of(run.path, run.checked, *truth) : infinite;
    if (!error) return std::nullopt;
    trial.error = *error;
    if (run.warned) trial.flags = "step";
  } catch (const Error&) {
    trial.refused = true;
  }
  return trial;
}

/// What a scene that is refused would have given: infinite where it does not end. Of the modal method.
double unguarded_error(const fem::Scene& scene, const fem::MotionHistory& motion,
                       const std::optional<Truth>& truth) {
  if (scene.simulation->method != fem::IntegrationMethod::modal)
    return std::numeric_limits<double>::quiet_NaN();
  fem::ModalSteppingOptions options;
  options.keep_events = false;
  options.tolerance = scene.simulation->tolerance;
  options.step = scene.simulation->step;
  const auto path = truth ? modal_path(scene, motion, options) : std::nullopt;
  return path ? *error_of(*path, path->rows(), *truth) : infinite;
}

LimitMap contact_limits(const LimitRun& run, fem::IntegrationMethod method, const std::vector<double>& steps,
                        const std::vector<double>& stiffnesses, LimitMap map) {
  map.quantity = "displacement of the contact points (largest error over largest displacement)";
  map.fails = "touch falls between steps, and the trajectory parts from the true one";
  map.sign =
      "a run with a quarter of the step up to 20 ms beyond the first touch, and a step of a "
      "third of the spring's period";
  map.then = "warns and tells the estimated error";
  map.axes = {run.axis("step [us]", steps), run.axis("stiffness [N/m]", stiffnesses),
              run.axis("dashpot [N s/m]", {1, 10, 100})};
  for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& contact) {
    for (const unsigned seed : run.draws(2)) {
      fem::Scene scene = rattling_scene(contact[0], contact[1], seed);
      const fem::MotionHistory motion = fem::scene_motion(scene);
      const std::optional<Truth> truth = truth_of(scene, motion, 1e-5);
      scene.simulation->method = method;
      for (const double step : map.axes[0].values) {
        scene.simulation->step = 1e-6 * step;
        if (method == fem::IntegrationMethod::modal) scene.simulation->contact_substeps = 1;
        auto trial = trial_of(scene, motion, truth, displacement_tolerance);
        if (!trial) continue;
        trial->at = {step, contact[0], contact[1]};
        trial->seed = seed;
        map.trials.push_back(std::move(*trial));
      }
    }
  });
  return map;
}

}  // namespace

LimitMap newmark_contact_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "newmark_contact";
  map.title = "Newmark stepping in contact: step, stiffness, dashpot";
  return contact_limits(run, fem::IntegrationMethod::newmark, {10, 20, 25, 50, 100}, {1e4, 1e5, 1e6},
                        std::move(map));
}

LimitMap modal_contact_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "modal_contact";
  map.title = "Modal stepping at a fixed step in contact";
  return contact_limits(run, fem::IntegrationMethod::modal, {2, 5, 10, 25}, {1e4, 1e5, 1e6, 1e7},
                        std::move(map));
}

LimitMap contact_tolerance_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "contact_tolerance";
  map.title = "Modal stepping in contact to a tolerance";
  map.quantity = "displacement of the contact points (largest error over largest displacement)";
  map.fails = "steps too long or modes too few let the trajectory part from the true one";
  map.sign =
      "trials against every mode at a 64th of their tolerance, its own error added, up to 20 ms beyond the "
      "first touch";
  map.then = "takes shorter steps and more modes, or warns and tells until when the path is known";
  map.axes = {run.axis("tolerance", {1e-3, 3e-3, 1e-2, 3e-2, 0.1}),
              run.axis("stiffness [N/m]", {1e4, 1e5, 1e6, 1e7}), run.axis("dashpot [N s/m]", {1, 100})};
  for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& contact) {
    for (const unsigned seed : run.draws(6)) {
      fem::Scene scene = rattling_scene(contact[0], contact[1], seed);
      const fem::MotionHistory motion = fem::scene_motion(scene);
      const std::optional<Truth> truth = truth_of(scene, motion, 1e-7);
      for (const double tolerance : map.axes[0].values) {
        scene.simulation->tolerance = tolerance;
        auto trial = trial_of(scene, motion, truth, tolerance);
        if (!trial) continue;
        trial->at = {tolerance, contact[0], contact[1]};
        trial->seed = seed;
        map.trials.push_back(std::move(*trial));
      }
    }
  });
  return map;
}

LimitMap stiff_wall_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "stiff_wall";
  map.title = "Stiff walls: 0 to a tolerance; 1 modal, 2 Newmark, steps 10 ms times it";
  map.quantity = "displacement of the contact points (largest error over largest displacement)";
  map.fails = "blows become shorter than any step, and the path parts or the run does not end";
  map.sign =
      "the spring over the wire's between its nodes, the checks of steps and tolerances, and a step "
      "of a third of the spring's period";
  map.then = "refuses with the hard stop that stands for it, or warns";
  map.axes = {run.axis("lg stiffness [N/m]", {5, 6, 7, 8, 9, 10, 11, 12}),
              run.axis("tolerance", {1e-4, 1e-3, 1e-2}), run.axis("method", {0, 1, 2})};
  for (const double decades : map.axes[0].values) {
    for (const unsigned seed : run.draws(2)) {
      const fem::Scene drawn = rattling_scene(std::pow(10.0, decades), 1.0, seed);
      const fem::MotionHistory motion = fem::scene_motion(drawn);
      const std::optional<Truth> truth = truth_of(drawn, motion, 1e-6);
      for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& place) {
        fem::Scene scene = drawn;
        fem::Simulation& simulation = *scene.simulation;
        const bool fixed = place[1] > 0.0;
        if (place[1] == 2.0) simulation.method = fem::IntegrationMethod::newmark;
        (fixed ? simulation.step : simulation.tolerance) = fixed ? 1e-2 * place[0] : place[0];
        auto trial = trial_of(scene, motion, truth, fixed ? displacement_tolerance : place[0]);
        if (!trial) return;
        trial->at = {decades, place[0], place[1]};
        trial->seed = seed;
        if (trial->refused) trial->error = unguarded_error(scene, motion, truth);
        map.trials.push_back(std::move(*trial));
      });
    }
  }
  return map;
}

}  // namespace struna::apps
