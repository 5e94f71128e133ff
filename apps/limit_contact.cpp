#include "apps/limit_contact.hpp"

#include <algorithm>
#include <optional>
#include <random>

#include "apps/tradeoff_simulation.hpp"
#include "fem/error.hpp"
#include "fem/simulation.hpp"

namespace struna::apps {
namespace {

constexpr double displacement_tolerance = 0.05;  ///< stated in docs/limits.md
constexpr double duration = 0.03;                ///< [s]
constexpr double parted = 0.005;  ///< of the largest displacement: beyond, two references have parted

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

Run run_of(const fem::Scene& scene, const fem::MotionHistory& motion) {
  const fem::TimeResponse response = fem::simulate(scene, motion);
  Run run;
  if (response.contacts.empty()) return run;
  // Every state has its own time bin; those at the record's samples are common to all methods.
  const fem::ContactMap& map = response.contacts[0];
  const long stride = response.report.oversampling;
  run.path.resize((map.penetration.rows() - 1) / stride + 1, map.penetration.cols());
  for (long i = 0; i < run.path.rows(); ++i)
    run.path.row(i) = map.penetration.row(i * stride).array() + map.gap;
  const auto& warnings = response.report.warnings;
  run.warned = told(warnings, "too long for the contacts") || told(warnings, "is not met");
  run.checked = static_cast<long>(response.report.error_checked_until / response.sample_interval);
  return run;
}

Run run_to_tolerance(fem::Scene scene, const fem::MotionHistory& motion, double tolerance) {
  scene.simulation->method = fem::IntegrationMethod::modal;
  scene.simulation->step = 0.0;
  scene.simulation->tolerance = tolerance;
  return run_of(scene, motion);
}

/// The path at a tolerance, up to where one at ten times the tolerance keeps within `limit` of the largest
/// displacement.
Eigen::MatrixXd reference_path(const fem::Scene& scene, const fem::MotionHistory& motion, double tolerance,
                               double limit) {
  const Eigen::MatrixXd fine = run_to_tolerance(scene, motion, tolerance).path;
  const Eigen::MatrixXd check = run_to_tolerance(scene, motion, 10.0 * tolerance).path;
  if (fine.rows() != check.rows()) return {};
  const double far = limit * fine.cwiseAbs().maxCoeff();
  long known = 0;
  while (known < fine.rows() && (fine.row(known) - check.row(known)).cwiseAbs().maxCoeff() <= far) ++known;
  return fine.topRows(known);
}

/// Largest error over the largest distance as far as both are known; nothing where that is nowhere.
std::optional<double> error_of(const Run& run, const Eigen::MatrixXd& reference) {
  const long n = std::min(run.checked, static_cast<long>(reference.rows()));
  if (n < 2) return std::nullopt;
  return (run.path.topRows(n) - reference.topRows(n)).cwiseAbs().maxCoeff() /
         reference.topRows(n).cwiseAbs().maxCoeff();
}

LimitMap contact_limits(const LimitRun& run, fem::IntegrationMethod method, const std::vector<double>& steps,
                        const std::vector<double>& stiffnesses, LimitMap map) {
  map.quantity = "displacement of the contact points (largest error over largest displacement)";
  map.fails = "touch falls between steps, and the trajectory parts from the true one";
  map.sign = "a run with a quarter of the step up to 20 ms beyond the first touch";
  map.then = "warns and tells the estimated error";
  map.axes = {run.axis("step [us]", steps), run.axis("stiffness [N/m]", stiffnesses),
              run.axis("dashpot [N s/m]", {1, 10, 100})};
  for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& contact) {
    for (const unsigned seed : run.draws(2)) {
      fem::Scene scene = rattling_scene(contact[0], contact[1], seed);
      const fem::MotionHistory motion = fem::scene_motion(scene);
      const Eigen::MatrixXd reference = reference_path(scene, motion, 1e-5, parted);
      scene.simulation->method = method;
      for (const double step : map.axes[0].values) {
        scene.simulation->step = 1e-6 * step;
        if (method == fem::IntegrationMethod::modal) scene.simulation->contact_substeps = 1;
        LimitTrial trial;
        trial.at = {step, contact[0], contact[1]};
        trial.seed = seed;
        trial.tolerance = displacement_tolerance;
        try {
          const Run stepped = run_of(scene, motion);
          const auto error = error_of(stepped, reference);
          if (!error) continue;
          trial.error = *error;
          if (stepped.warned) trial.flags = "step";
        } catch (const Error&) {
          trial.refused = true;
        }
        map.trials.push_back(std::move(trial));
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
  map.sign = "trials against every mode and a tenth of the tolerance, up to 20 ms beyond the first touch";
  map.then = "takes shorter steps and more modes, and warns where the tolerance is not met";
  map.axes = {run.axis("tolerance", {1e-3, 3e-3, 1e-2, 3e-2, 0.1}),
              run.axis("stiffness [N/m]", {1e4, 1e5, 1e6, 1e7}), run.axis("dashpot [N s/m]", {1, 100})};
  for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& contact) {
    for (const unsigned seed : run.draws(2)) {
      const fem::Scene scene = rattling_scene(contact[0], contact[1], seed);
      const fem::MotionHistory motion = fem::scene_motion(scene);
      const Eigen::MatrixXd reference = reference_path(scene, motion, 1e-6, 1e-4);
      for (const double tolerance : map.axes[0].values) {
        const Run stepped = run_to_tolerance(scene, motion, tolerance);
        const auto error = error_of(stepped, reference);
        if (!error) continue;
        LimitTrial trial;
        trial.at = {tolerance, contact[0], contact[1]};
        trial.seed = seed;
        trial.error = *error;
        trial.tolerance = tolerance;
        if (stepped.warned) trial.flags = "tolerance";
        map.trials.push_back(std::move(trial));
      }
    }
  });
  return map;
}

}  // namespace struna::apps
