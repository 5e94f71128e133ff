#include "apps/limit_stepping.hpp"

#include <cmath>
#include <numbers>

#include "fem/accuracy_choice.hpp"
#include "fem/body_dynamics.hpp"
#include "fem/error.hpp"
#include "fem/motion.hpp"
#include "fem/newmark_error.hpp"

namespace struna::apps {
namespace {

using Eigen::ArrayXd;

constexpr double highest_hz = 300.0;
constexpr double duration = 0.2;          ///< [s]
constexpr double force_tolerance = 0.05;  ///< stated in docs/limits.md
constexpr double noticed = 0.05;
constexpr int finest = 512;                                                       ///< steps per period
const fem::Rayleigh rayleigh{0.0, 0.02 / (2.0 * std::numbers::pi * highest_hz)};  // 1 % at the upper edge

/// The wire relative to its base, in its modes: q'' + beta w^2 q' + w^2 q = -Gamma u''. As what the modal
/// stepper takes, and as what Newmark's takes: the modes are then its degrees of freedom.
struct ShakenModes {
  fem::ModalBody exact;
  fem::NodalBody nodal;
  Eigen::VectorXd middle;  ///< displacement of the wire's middle per unit q

  ShakenModes() {
    fem::Body wire{
        "wire", fem::straight_line({0, 0, 0}, {0.68, 0, 0}), fem::solid_circle(0.0032), 7650.0, 0.3, {}};
    wire.material.youngs_modulus = fem::constant_law(120e9);
    wire.material.rayleigh = rayleigh;
    wire.material.damping = fem::Damping::viscous;
    const fem::Model model = fem::assemble(wire, 16);
    const fem::Eigenmodes modes = fem::solve_eigenmodes(model);
    exact.poles = fem::pole_system(model, modes, fem::Damping::viscous, highest_hz);
    exact.load = Eigen::MatrixX3d::Zero(modes.eigenvalue.size(), 3);
    exact.load.col(2) = -modes.shape.transpose() * fem::gravity_load(model, Eigen::Vector3d::UnitY());
    middle = modes.shape.transpose() * fem::point_functional(model, 0.5, Eigen::Vector3d::UnitY());
    nodal.mass.lower = Eigen::MatrixXd::Ones(1, modes.eigenvalue.size());
    nodal.stiffness.lower = 120e9 * modes.eigenvalue.transpose();
    nodal.rayleigh = rayleigh;
    nodal.load = exact.load;
  }
};

/// Force of the supports on the wire beyond what its mass takes, Gamma . (q'' - p).
double force_of(const ShakenModes& wire, const fem::ModalStepper& stepper, const fem::MotionHistory&,
                double) {
  return wire.exact.load.col(2).dot(stepper.internal_force(0));
}
template <class Newmark>
double force_of(const ShakenModes& wire, const Newmark& stepper, const fem::MotionHistory& motion, double t) {
  const Eigen::VectorXd& gamma = wire.exact.load.col(2);
  return gamma.dot(gamma * motion.at(t).acceleration - stepper.acceleration(0));
}

/// Newmark's scheme without its refusals, mode by mode, from rest: what a pair would do.
class UnguardedNewmark {
 public:
  UnguardedNewmark(const ShakenModes& wire, const fem::MotionHistory& motion,
                   const fem::NewmarkOptions& options)
      : motion_(motion),
        options_(options),
        stiffness_(wire.nodal.stiffness.lower.transpose().array()),
        load_(wire.nodal.load.col(2).array()),
        x_(ArrayXd::Zero(stiffness_.size())),
        v_(x_),
        a_(load_ * motion.at(0.0).acceleration) {}

  void advance(double time) {
    const double h = options_.step, kappa = options_.kappa, lambda = options_.lambda;
    x_ += h * v_ + h * h * (0.5 - kappa) * a_;
    v_ += h * (1.0 - lambda) * a_;
    const ArrayXd damping = rayleigh.beta * stiffness_;
    a_ = (load_ * motion_.at(time).acceleration - damping * v_ - stiffness_ * x_) /
         (1.0 + lambda * h * damping + kappa * h * h * stiffness_);
    x_ += h * h * kappa * a_;
    v_ += h * lambda * a_;
  }
  Eigen::VectorXd acceleration(int) const { return a_.matrix(); }

 private:
  const fem::MotionHistory& motion_;
  fem::NewmarkOptions options_;
  ArrayXd stiffness_, load_, x_, v_, a_;
};

fem::MotionHistory shaking(unsigned seed) {
  fem::Excitation excitation;
  excitation.kind = fem::Excitation::Kind::random;
  excitation.band_lo_hz = 10.0;
  excitation.band_hi_hz = highest_hz;
  excitation.rms_acceleration = 1.0;
  excitation.seed = seed;
  return fem::motion_history(excitation, duration);
}

/// The force at the ends of steps of 1/(steps_per_period highest_hz).
template <class Stepper>
ArrayXd path(const ShakenModes& wire, Stepper& stepper, const fem::MotionHistory& motion,
             int steps_per_period) {
  const auto count = std::lround(duration * highest_hz * steps_per_period);
  ArrayXd y(count);
  for (long i = 0; i < count; ++i) {
    const double t = duration * static_cast<double>(i + 1) / static_cast<double>(count);
    stepper.advance(t);
    y[i] = force_of(wire, stepper, motion, t);
  }
  return y;
}

/// One pair at one step: refused, or stepped.
LimitTrial trial_of(const ShakenModes& wire, const fem::MotionHistory& motion, const ArrayXd& reference,
                    const fem::NewmarkOptions& options, int steps_per_period) {
  const auto at = [&](double t) { return motion.at(t); };
  LimitTrial trial;
  trial.tolerance = force_tolerance;
  ArrayXd y;
  try {
    fem::NewmarkStepper stepper({wire.nodal}, {}, at, options);
    y = path(wire, stepper, motion, steps_per_period);
    const double told = fem::newmark_error(options, wire.exact, rayleigh, at, highest_hz, duration);
    if (told > noticed) trial.flags = "step";
  } catch (const Error&) {
    UnguardedNewmark unguarded(wire, motion, options);
    y = path(wire, unguarded, motion, steps_per_period);
    trial.refused = true;
  }
  const long stride = finest / steps_per_period;
  const ArrayXd exact = reference(Eigen::seqN(stride - 1, y.size(), stride));
  trial.error = std::sqrt((y - exact).square().sum() / exact.square().sum());
  return trial;
}

/// Displacement of the middle and force of the supports, 20 times a period at the band's upper edge, with
/// modes above `highest_mode_hz` left to statics; 0: every mode is stepped.
Eigen::ArrayX2d cut_paths(const ShakenModes& wire, const fem::MotionHistory& motion, double highest_mode_hz) {
  fem::ModalSteppingOptions options;
  options.tolerance = 1e-6;
  options.longest_step = 1.0 / (40.0 * highest_hz);
  options.highest_mode_hz = highest_mode_hz;
  fem::ModalStepper stepper(
      {wire.exact}, {}, [&](double t) { return motion.at(t); }, options);
  Eigen::ArrayX2d y(std::lround(20.0 * highest_hz * duration), 2);
  for (long i = 0; i < y.rows(); ++i) {
    const double t = duration * static_cast<double>(i + 1) / static_cast<double>(y.rows());
    stepper.advance(t);
    y(i, 0) = wire.middle.dot(stepper.displacement(0));
    y(i, 1) = force_of(wire, stepper, motion, t);
  }
  return y;
}

}  // namespace

LimitMap newmark_parameter_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "newmark_parameters";
  map.title = "Newmark's kappa and lambda over the step";
  map.quantity = "force of the supports (rms over rms)";
  map.fails =
      "with lambda < 1/2 or kappa < lambda/2 the mesh's fastest modes grow without bound, with lambda > 1/2 "
      "resonances lose what damping leaves them";
  map.sign = "the pair itself, and what it makes of the modes up to twice the band's end under this motion";
  map.then = "refuses the pair, or tells the error";
  map.axes = {run.axis("kappa", {0.05, 0.15, 0.2, 0.25, 0.3025, 0.4, 0.6, 1}),
              run.axis("lambda", {0.3, 0.45, 0.49, 0.5, 0.55, 0.6, 0.8, 1}),
              run.axis("steps per period", {8, 16, 32, 64, 128, 256, finest})};
  const ShakenModes wire;
  for (const unsigned seed : run.draws(2)) {
    const fem::MotionHistory motion = shaking(seed);
    fem::ModalStepper exact({wire.exact}, {}, [&](double t) { return motion.at(t); });
    const ArrayXd reference = path(wire, exact, motion, finest);
    for_each_place(map.axes, [&](const std::vector<double>& at) {
      fem::NewmarkOptions options;
      options.kappa = at[0];
      options.lambda = at[1];
      options.step = 1.0 / (at[2] * highest_hz);
      LimitTrial trial = trial_of(wire, motion, reference, options, static_cast<int>(at[2]));
      trial.at = at;
      trial.seed = seed;
      map.trials.push_back(std::move(trial));
    });
  }
  return map;
}

LimitMap truncation_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "truncation";
  map.title = "Modes left to statics: 0 displacement, 1 force";
  map.quantity =
      "displacement of the wire's middle or force of its supports (largest error over largest value)";
  map.fails = "a mode that only follows statically lacks (f/f_r)^2 of its answer";
  map.sign = "that share at the band's upper edge, against the tolerance";
  map.then = "does not leave such a mode to statics, and steps it";
  map.axes = {run.axis("cut over the band's end", {0.3, 0.7, 1, 1.5, 2, 3.5, 5, 10.5, 20, 35, 105}),
              run.axis("tolerance", {1e-4, 1e-3, 1e-2, 0.1}), run.axis("quantity", {0, 1})};
  const ShakenModes wire;
  for (const unsigned seed : run.draws(3)) {
    const fem::MotionHistory motion = shaking(seed);
    const Eigen::ArrayX2d reference = cut_paths(wire, motion, 0.0);
    for (const double cut : map.axes[0].values) {
      const Eigen::ArrayX2d y = cut_paths(wire, motion, cut * highest_hz);
      for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& at) {
        const auto quantity = static_cast<long>(at[1]);
        LimitTrial trial;
        trial.at = {cut, at[0], at[1]};
        trial.seed = seed;
        trial.tolerance = at[0];
        trial.error = (y.col(quantity) - reference.col(quantity)).abs().maxCoeff() /
                      reference.col(quantity).abs().maxCoeff();
        trial.refused = cut * highest_hz < fem::static_mode_limit(highest_hz, at[0]);
        map.trials.push_back(std::move(trial));
      });
    }
  }
  return map;
}

}  // namespace struna::apps
