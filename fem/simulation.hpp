#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fem/accuracy_choice.hpp"
#include "fem/motion.hpp"
#include "fem/scene.hpp"
#include "fem/sizing.hpp"

namespace struna::fem {

/// What one contact of the scene did, over time and length.
struct ContactMap {
  std::string inside;
  std::string outside;
  double gap = 0.0;             ///< [m]
  Eigen::VectorXd arc_length;   ///< of the possible contact points on the inside body [m]
  double interval = 0.0;        ///< length of a time bin [s]
  Eigen::MatrixXd penetration;  ///< largest |h| - gap in the bin, bins x points [m]; negative: open
  Eigen::MatrixXd force;        ///< largest force in the bin, bins x points [N]
};

struct SimulatedBody {
  std::string name;
  int elements = 0;
  MeshChoice mesh;  ///< natural frequencies up to the motion's highest frequency
  double largest_bending_strain = 0.0;
  double largest_slope = 0.0;  ///< rotation of a cross-section, that of the moved supports' static shape
                               ///< included, at up to 2000 instants of the run [rad]
  double stretch_stiffening =
      0.0;  ///< axial force of the stretch that the deflection would cause, over the Euler load: about
            ///< the relative rise of the first natural frequency squared that linear theory leaves out
};

struct SimulationReport {
  double highest_hz = 0.0;  ///< of the motion, which the choices were made for
  IntegrationMethod method = IntegrationMethod::modal;
  bool linear = false;  ///< no contact, or none that can close: the linear solution is the whole answer
  double largest_offset = 0.0;   ///< linear runs: largest |h|/gap reached at any contact point
  double tolerance = 0.0;        ///< asked, of the largest displacement; 0 when the step was fixed
  double step = 0.0;             ///< when fixed [s]
  double highest_mode_hz = 0.0;  ///< modal: modes above follow statically; 0: every mode is stepped
  double estimated_error = 0.0;  ///< with contact, of a contact point's displacement over the largest one:
                                 ///< up to 20 ms beyond the first touch, against a refined run whose own error
                                 ///< is added (accuracy_choice.hpp, step_check.hpp); 0: not estimated (linear)
  double error_checked_until = 0.0;        ///< [s]
  std::optional<AccuracyChoice> accuracy;  ///< how modes and steps were chosen; nothing where nothing touched
  std::optional<double> causal_distance;   ///< modal, structural damping: of the law used in time from the
                                           ///< harmonic response, rms over the band; docs/pole_system.md
  double start_penetration = 0.0;  ///< with contact: how deep the run starts, beyond any gap [m]; else 0
  int oversampling = 1;            ///< states sampled per record sample before the anti-alias filter
  StepReport steps;
  std::optional<EnergyLedger> energy;  ///< modal method
  std::vector<SimulatedBody> bodies;
  bool complete = true;  ///< false: interrupted, what was computed is kept
  std::vector<std::string> warnings;
};

/// A run: what a sensor set would have recorded.
struct TimeResponse {
  double sample_interval = 0.0;    ///< [s]
  Eigen::VectorXd motion;          ///< u(t): displacement along the drive [m], or force [N]
  std::vector<std::string> names;  ///< of the outputs
  Eigen::MatrixXd output;  ///< samples x outputs; forces are those that the support exerts on the structure
  std::vector<ContactMap> contacts;
  SimulationReport report;
};

/// Called now and then with the time reached [s]; false stops the run, which keeps what was computed.
using SimulationProgress = std::function<bool(double)>;

/// Called with each warning as soon as it is known, most of them before the run.
using SimulationWarning = std::function<void(const std::string&)>;

/// Whole sampling intervals in the duration.
long sample_intervals(const Simulation& simulation);

/// (w dt)^2/12, by which constant average acceleration lengthens the period at f (Bathe, Finite Element
/// Procedures, section 9.4).
double newmark_period_error(double step, double f_hz);

/// The motion of the scene's excitation. Throws Error for a record (its samples are not here) and for a force
/// drive, which only a record of a force can describe.
MotionHistory scene_motion(const Scene& scene);

/// Runs a scene in time, from the static shape moving with the base (and the static rest under gravity).
/// Only the measured body and those that contacts join to it take part. The linear
/// solution comes first: where it cannot close any gap it is the answer. docs/simulation.md. Throws Error on
/// a scene without drive, measurement or simulation, on a motion shorter than the duration, on a measured
/// body that nothing moves, and where the method cannot represent the material (newmark: constant modulus,
/// Rayleigh damping).
/// `levels`: the report's accuracy tells what coarser settings would give.
TimeResponse simulate(const Scene& scene, const MotionHistory& motion,
                      const SimulationProgress& progress = {}, const SimulationWarning& tell = {},
                      bool levels = false);

}  // namespace struna::fem
