#pragma once

#include "fem/simulation.hpp"
#include "fem/simulation_plan.hpp"

namespace struna::fem {

/// Both schemes, as far as sampling them is concerned.
class Stepper {
 public:
  virtual ~Stepper() = default;
  virtual void advance(double time) = 0;
  virtual Eigen::VectorXd displacement(int body) const = 0;
  virtual Eigen::VectorXd velocity(int body) const = 0;
  virtual Eigen::VectorXd acceleration(int body, const MotionSample& u) const = 0;
  virtual double penetration(int point) const = 0;
  virtual double force(int point) const = 0;
  virtual Eigen::Vector2d offset(int point) const = 0;
  virtual StepReport steps() const = 0;
  virtual std::optional<EnergyLedger> energy() const = 0;

  /// Contact force on the inside body, in the point's plane.
  Eigen::Vector2d force_on_inside(int point) const {
    const double size = force(point);
    if (size == 0.0) return Eigen::Vector2d::Zero();
    return -size * offset(point).normalized();
  }
};

/// How a run is sampled.
struct Sampling {
  double rate = 0.0;           ///< of the record [Hz]
  int oversampling = 1;        ///< states per record sample
  bool filter = false;         ///< anti-alias before keeping every oversampling-th; otherwise just keep
  bool filter_motion = false;  ///< the motion too: it holds more than half the record's rate can
  long samples = 0;            ///< of the record
  double interval() const { return 1.0 / (rate * oversampling); }
};

/// Checks against the gaps per period of the fastest motion, in a linear run: between them a peak rises by
/// another 1 - cos(pi/20) = 1.2 % at most.
constexpr double checks_per_period = 20.0;

enum class RunEnd { complete, interrupted, gap_closed };

/// Steps through a run and samples it into `response`: motion, output, contact maps, report. Without
/// `contact` the stepper knows no gaps; they are watched here, and the run ends as soon as one comes within 3
/// % of closing. The last fine samples are left out where the motion ends before them.
RunEnd run(Stepper& stepper, const SimulationPlan& plan, const MaxwellLaw& law, const MotionHistory& motion,
           const Sampling& sampling, bool contact, const SimulationProgress& progress,
           TimeResponse& response);

}  // namespace struna::fem
