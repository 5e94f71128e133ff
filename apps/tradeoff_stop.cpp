// The wire against a stop at its middle (tradeoff_simulation.hpp): steppers of fem/ themselves, without a
// scene, so that the number of modes stepped can be turned as well.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "apps/tradeoff_simulation.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/newmark.hpp"

namespace struna::apps {
namespace {

constexpr int elements = 28;
constexpr double modulus = 120e9;
constexpr double gap = 1e-3;        ///< [m]
constexpr double shaken_hz = 25.0;  ///< the first natural frequency is 24.4 Hz
const fem::Rayleigh rayleigh{2.0, 1e-5};

fem::MotionSample motion(double t) {
  const double omega = 2.0 * std::numbers::pi * shaken_hz;
  return {-20.0 / (omega * omega) * std::sin(omega * t), -20.0 / omega * std::cos(omega * t),
          20.0 * std::sin(omega * t)};
}

/// The wire relative to its base: it is loaded by the base's acceleration alone, and damped by relative
/// velocity.
struct StopProblem {
  fem::ModalBody modal;
  fem::NodalBody nodal;
  fem::ContactPoint modal_stop, nodal_stop;

  StopProblem() {
    fem::Body wire{
        "wire", fem::straight_line({0, 0, 0}, {0.68, 0, 0}), fem::solid_circle(0.0032), 7650.0, 0.3, {}};
    wire.material.youngs_modulus = fem::constant_law(modulus);
    wire.material.rayleigh = rayleigh;
    wire.material.damping = fem::Damping::viscous;
    const fem::Model model = fem::assemble(wire, elements);
    Eigen::VectorXd along = Eigen::VectorXd::Zero(model.dof_count());
    for (long i = 1; i < along.size(); i += 6) along[i] = 1.0;
    const Eigen::VectorXd inertia = fem::multiply(model.mass, along);
    const Eigen::VectorXd middle = fem::point_functional(model, 0.5, Eigen::Vector3d::UnitY());

    const fem::Eigenmodes modes = fem::solve_eigenmodes(model);
    modal.poles = fem::pole_system(model, modes, fem::Damping::viscous, 1e4);
    modal.load = Eigen::MatrixX3d::Zero(modes.shape.cols(), 3);
    modal.load.col(2) = -modes.shape.transpose() * inertia;
    modal_stop = stop_with(modes.shape.transpose() * middle);

    nodal = fem::nodal_body(model, modulus, rayleigh, {}, Eigen::Vector3d::UnitY());
    nodal.load.col(2) = -inertia(model.free_dof);
    nodal_stop = stop_with(middle(model.free_dof));
  }

  static fem::ContactPoint stop_with(const Eigen::VectorXd& weights) {
    fem::ContactPoint stop;
    stop.law = {fem::ContactLaw::no_adhesion, 1e5, 100.0};
    stop.gap = gap;
    stop.shape = fem::StopShape::wall;
    stop.inside = Eigen::MatrixX2d::Zero(weights.size(), 2);
    stop.inside.col(0) = weights;
    return stop;
  }

  fem::ModalStepper stepper(const fem::ModalSteppingOptions& options) const {
    return {{modal}, {modal_stop}, motion, options};
  }
  fem::NewmarkStepper stepper(const fem::NewmarkOptions& options) const {
    return {{nodal}, {nodal_stop}, motion, options};
  }
};

/// Displacement of the middle at 1000 instants per second.
template <class Options>
Eigen::VectorXd path(const StopProblem& problem, const Options& options, double duration) {
  auto stepper = problem.stepper(options);
  Eigen::VectorXd y(std::lround(1000.0 * duration));
  for (long i = 0; i < y.size(); ++i) {
    stepper.advance(duration * static_cast<double>(i + 1) / static_cast<double>(y.size()));
    y(i) = stepper.offset(0)[0];
  }
  return y;
}

fem::ModalSteppingOptions modal_options(double tolerance, double step = 0.0) {
  fem::ModalSteppingOptions options;
  if (tolerance > 0.0) options.tolerance = tolerance;
  options.step = step;
  options.contact_substeps = 20;
  return options;
}

}  // namespace

TradeoffChart wire_against_stop(double duration, const TradeoffRun& run) {
  const StopProblem problem;
  run.progress("simulation: wire against a stop, reference");
  const Eigen::VectorXd reference = path(problem, modal_options(1e-7), duration);
  const Eigen::VectorXd check = path(problem, modal_options(0.0, 2e-6), duration);
  const auto distance = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a - b).cwiseAbs().maxCoeff() / gap;
  };
  TradeoffChart chart;
  chart.stage = "simulation";
  chart.problem = "wire against a stop";
  chart.quantity = "displacement";
  chart.error_label = fmt::format("largest error of the middle over {:g} s, of the gap", duration);
  chart.reference =
      "modal method at a tolerance of 1e-07; its error is its distance from a fixed step of 2e-06 s";
  chart.reference_error = distance(check, reference);

  const auto add = [&](TradeoffRow row, const auto& options) {
    run.progress(fmt::format("simulation: wire against a stop, {}, {:g}", row.method, row.value));
    Eigen::VectorXd y;
    row.seconds = best_seconds(run.timing, [&] { y = path(problem, options, duration); });
    row.error = distance(y, reference);
    chart.rows.push_back(row);
  };
  for (const double tolerance : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5}) {
    TradeoffRow row{"modal; to a tolerance", "tolerance [-]", tolerance};
    row.is_default = tolerance == fem::Simulation{}.tolerance;
    add(row, modal_options(tolerance));
  }
  for (const double step : {2e-4, 1e-4, 5e-5, 2e-5, 1e-5})
    add({"modal; fixed step (cut 20)", "step [s]", step}, modal_options(0.0, step));
  for (const int modes : {5, 10, 20, 40}) {
    fem::ModalSteppingOptions options = modal_options(1e-4);
    // Between the natural frequencies of the bending modes in one plane, of a straight clamped wire.
    options.highest_mode_hz = 24.4 * std::pow((modes + 1.0) / 1.5056, 2);
    add({"modal; tolerance 1e-4; other modes static", "modes per plane [-]", static_cast<double>(modes)},
        options);
  }
  for (const double step : {1e-4, 5e-5, 2e-5, 1e-5, 5e-6}) {
    fem::NewmarkOptions options;
    options.step = step;
    add({"newmark", "step [s]", step}, options);
  }
  mark_pareto(chart);
  return chart;
}

}  // namespace struna::apps
