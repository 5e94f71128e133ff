// What a fixed step leaves in error where bodies touch: a wire against a stop at its middle.
#include "fem/step_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/eigenmodes.hpp"

namespace struna::fem {
namespace {

constexpr double gap = 1e-3;         // [m]
constexpr double first_touch = 0.1;  // [s], after it at the latest

MotionSample shaken(double t) {
  const double omega = 2.0 * std::numbers::pi * 25.0;  // the first natural frequency is 24.4 Hz
  return {-20.0 / (omega * omega) * std::sin(omega * t), -20.0 / omega * std::cos(omega * t),
          20.0 * std::sin(omega * t)};
}

struct Stopped {
  ModalBody modal;
  NodalBody nodal;
  ContactPoint modal_stop, nodal_stop;

  Stopped() {
    Body wire{"wire", straight_line({0, 0, 0}, {0.68, 0, 0}), solid_circle(0.0032), 7650.0, 0.3, {}};
    wire.material.youngs_modulus = constant_law(120e9);
    wire.material.rayleigh = {2.0, 1e-5};
    wire.material.damping = Damping::viscous;
    const Model model = assemble(wire, 12);
    Eigen::VectorXd along = Eigen::VectorXd::Zero(model.dof_count());
    for (long i = 1; i < along.size(); i += 6) along[i] = 1.0;
    const Eigen::VectorXd inertia = multiply(model.mass, along);
    const Eigen::VectorXd middle = point_functional(model, 0.5, Eigen::Vector3d::UnitY());
    const Eigenmodes modes = solve_eigenmodes(model);
    modal.poles = pole_system(model, modes, Damping::viscous, 1e4);
    modal.load = Eigen::MatrixX3d::Zero(modes.shape.cols(), 3);
    modal.load.col(2) = -modes.shape.transpose() * inertia;
    modal_stop = stop_with(modes.shape.transpose() * middle);
    nodal = nodal_body(model, 120e9, wire.material.rayleigh, {}, Eigen::Vector3d::UnitY());
    nodal.load.col(2) = -inertia(model.free_dof);
    nodal_stop = stop_with(middle(model.free_dof));
  }

  static ContactPoint stop_with(const Eigen::VectorXd& weights) {
    ContactPoint stop;
    stop.law = {ContactLaw::no_adhesion, 1e5, 100.0};
    stop.gap = gap;
    stop.shape = StopShape::wall;
    stop.inside = Eigen::MatrixX2d::Zero(weights.size(), 2);
    stop.inside.col(0) = weights;
    return stop;
  }

  StepCheck newmark(double step, double duration = first_touch) const {
    NewmarkOptions options;
    options.step = step;
    return check_step({nodal}, {nodal_stop}, shaken, duration, options, false);
  }
  StepCheck by_modes(double step) const {
    ModalSteppingOptions options;
    options.step = step;
    return check_step({modal}, {modal_stop}, shaken, first_touch, options, false);
  }

  /// Largest distance of Newmark's path from that of the modal method to a tolerance, over the largest
  /// displacement.
  double true_error(double step, double until) const {
    NewmarkOptions options;
    options.step = step;
    NewmarkStepper stepped({nodal}, {nodal_stop}, shaken, options);
    stepped.follow_base();
    ModalSteppingOptions exact;
    exact.tolerance = 1e-6;
    ModalStepper reference({modal}, {modal_stop}, shaken, exact);
    double worst = 0.0, largest = 0.0;
    for (long i = 1; static_cast<double>(i) * step <= until; ++i) {
      stepped.advance(static_cast<double>(i) * step);
      reference.advance(static_cast<double>(i) * step);
      worst = std::max(worst, std::abs(stepped.offset(0)[0] - reference.offset(0)[0]));
      largest = std::max(largest, std::abs(reference.offset(0)[0]));
    }
    return worst / largest;
  }
};

TEST(StepCheck, TellsNewmarksErrorWithinAFactorOfThree) {
  const Stopped problem;
  for (const double step : {1e-4, 5e-5, 2e-5}) {
    const StepCheck check = problem.newmark(step);
    ASSERT_GT(check.checked_until, 0.02) << step;
    const double error = problem.true_error(step, check.checked_until);
    // First order holds in the mean only: where in a step a touch falls is chance.
    EXPECT_LT(check.estimated_error, 3.0 * error) << step;
    EXPECT_GT(check.estimated_error, error / 3.0) << step;
  }
}

TEST(StepCheck, FindsAModalStepBetterThanNewmarks) {
  const Stopped problem;
  const double modal = problem.by_modes(5e-5).estimated_error;
  EXPECT_GT(modal, 0.0);
  EXPECT_LT(modal, problem.newmark(5e-5).estimated_error);
}

TEST(StepCheck, ChecksNothingWhereNothingTouches) {
  const StepCheck check = Stopped().newmark(1e-4, 0.005);
  EXPECT_EQ(check.estimated_error, 0.0);
  EXPECT_EQ(check.checked_until, 0.0);
  EXPECT_FALSE(check.interrupted);
}

TEST(StepCheck, StopsWhenAsked) {
  const Stopped problem;
  NewmarkOptions options;
  options.step = 1e-4;
  const auto never = [](double) { return false; };
  EXPECT_TRUE(
      check_step({problem.nodal}, {problem.nodal_stop}, shaken, 1.0, options, false, never).interrupted);
}

}  // namespace
}  // namespace struna::fem
