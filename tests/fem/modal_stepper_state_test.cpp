#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "fem/modal_stepping.hpp"
#include "oscillators.hpp"
#include "wb1.hpp"

namespace struna::fem {
namespace {

using testing::oscillators;
using testing::still;
using testing::vector;
using testing::wall;
using testing::Wb1Modal;
constexpr double pi = std::numbers::pi;

/// q'' + drag q' = p, p = 2 u + 3 u'.
ModalBody rigid_body(double drag) {
  ModalBody body;
  body.poles.modes = 1;
  body.poles.pole = Eigen::VectorXcd::Constant(1, -drag);
  body.poles.residue = Eigen::VectorXcd::Constant(1, 1.0);
  body.poles.mode = Eigen::VectorXi::Zero(1);
  body.load = Eigen::MatrixX3d::Zero(1, 3);
  body.load(0, 0) = 2.0;
  body.load(0, 1) = 3.0;
  return body;
}

TEST(ModalStepperState, ConcentricRestNeedsNoNormal) {
  // h = 0 exactly at start: no force, no direction, until the motion parts them.
  ModalBody body = oscillators({80.0, 80.0}, 0.01);
  body.load.col(2) << -1.0, -0.5;
  ContactPoint point;
  point.law = {ContactLaw::approach, 1e5, 50.0};
  point.gap = 2e-4;
  point.inside = Eigen::MatrixX2d::Identity(2, 2);
  const auto shake = [](double t) {
    const double w = 90.0;
    return MotionSample{1e-3 * std::sin(w * t), 1e-3 * w * std::cos(w * t), -1e-3 * w * w * std::sin(w * t)};
  };
  ModalStepper stepper({body}, {point}, shake);
  EXPECT_EQ(stepper.offset(0).norm(), 0.0);
  stepper.advance(0.3);
  EXPECT_GT(stepper.report().events, 4);
  // Both coordinates are driven in proportion and the normal points along it.
  EXPECT_NEAR(stepper.offset(0)[1] / stepper.offset(0)[0], 0.5, 1e-9);
}

TEST(ModalStepperState, StaticModesKeepTheirFlexibility) {
  // With the modes above the 22nd left to statics the contact keeps its local softness, and the ledger still
  // closes.
  const Wb1Modal wb1;
  ModalSteppingOptions options;
  options.tolerance = 1e-4;
  options.highest_mode_hz = 24.4 * 22.5 * 22.5 * 4.0 / 9.0;  // f_n = f_1 ((2n + 1)/3)^2, between 22 and 23
  ModalStepper stepper = wb1.stepper(options);
  double error = 0.0;
  for (const testing::Wb1Value& value : testing::wb1_displacement) {
    stepper.advance(value.time);
    error = std::max(error, std::abs(stepper.offset(0)[0] - value.displacement));
  }
  EXPECT_GE(stepper.report().modes, 20);
  EXPECT_LE(stepper.report().modes, 22);
  EXPECT_EQ(stepper.report().modes + stepper.report().static_modes, 54);
  // Truncation: measured 8e-4 of the gap with 22 modes. The ledger is as exact as with all modes.
  EXPECT_LT(error, 4e-3 * testing::wb1_gap);
  EXPECT_LT(std::abs(stepper.energy().imbalance()), 1e-6 * stepper.energy().input);
}

TEST(ModalStepperState, FewModesStartInContactWithoutSwinging) {
  // Pressed 0.1 mm into the stop, all but two modes static: those stand in equilibrium with the stop at once,
  // and a stiff undamped spring in series with them does not swing from step to step.
  Wb1Modal wb1;
  wb1.stop.rest_offset[0] += wb1.stop.gap + 1e-4;
  for (const double stiffness : {1e5, 1e7, 1e9}) {
    wb1.stop.law = {ContactLaw::no_adhesion, stiffness, 0.0};
    ModalSteppingOptions options;
    options.highest_mode_hz = 80.0;
    ModalStepper stepper({wb1.body}, {wb1.stop}, still, options);
    ASSERT_GT(stepper.report().static_modes, 20);
    const double start = stepper.force(0);
    EXPECT_GT(start, 0.0);
    stepper.advance(1e-6);
    EXPECT_NEAR(stepper.force(0), start, 1e-3 * start);  // the two modes have hardly moved
    stepper.advance(stiffness > 1e8 ? 5e-4 : 0.1);       // 9, 9000 and 6000 events
    EXPECT_GT(stepper.report().events, 5);
    EXPECT_LT(std::abs(stepper.energy().imbalance()), 1e-6 * stepper.energy().initial);
  }
}

TEST(ModalStepperState, GravityStartsFromItsStaticRestWithContact) {
  // Weight 5 N on a spring of 1e3 N/m, wall at 1 mm of stiffness 1e4: x = (5 + 1e4 * 1e-3)/(1e3 + 1e4).
  ModalBody body = oscillators({std::sqrt(1e3)}, 0.02);
  body.constant_load = vector({5.0});
  for (const ContactLaw kind : {ContactLaw::approach, ContactLaw::no_adhesion}) {
    ModalStepper stepper({body}, {wall({kind, 1e4, 10.0}, 1e-3, {1.0})}, still);
    stepper.settle();
    const double expected = (5.0 + 10.0) / 1.1e4;
    EXPECT_NEAR(stepper.displacement(0)[0], expected, 1e-15);
    EXPECT_NEAR(stepper.force(0), 1e4 * (expected - 1e-3), 1e-9);
    stepper.advance(0.5);  // and it stays there; g is known to 1e-16 of the offset of 1 m
    EXPECT_NEAR(stepper.displacement(0)[0], expected, 1e-13);
  }
}

TEST(ModalStepperState, RigidModesDriftExactlyAndTheirLedgerCloses) {
  // u = 0.5 + 0.1 t: a load on a straight line, which the step follows exactly.
  const auto ramp = [](double t) { return MotionSample{0.5 + 0.1 * t, 0.1, 0.0}; };
  const double p0 = 2.0 * 0.5 + 3.0 * 0.1, p1 = 2.0 * 0.1, v0 = 0.7;
  for (const double drag : {0.0, 1e-9, 1e-3, 10.0, 2000.0}) {
    ModalSteppingOptions options;
    options.step = 0.01;
    ModalStepper stepper({rigid_body(drag)}, {}, ramp, options);
    stepper.set_state(0, vector({0.3}), vector({v0}));
    const double t = 20.0;
    stepper.advance(t);
    // v = v0 + p0 t + p1 t^2/2 for little drag (its own effect, (drag t) of it, is asked for beyond 1e-3
    // only).
    double v = v0 + p0 * t + 0.5 * p1 * t * t;
    double q = 0.3 + v0 * t + 0.5 * p0 * t * t + p1 * t * t * t / 6.0;
    double tolerance = 1e-13 + drag * t;
    if (drag >= 1e-3) {
      const double decay = std::exp(-drag * t);
      const double end = (p0 - p1 / drag) / drag;  // v = (v0 - end) e + end + p1 t/drag
      v = (v0 - end) * decay + end + p1 * t / drag;
      q = 0.3 - (v0 - end) * std::expm1(-drag * t) / drag + end * t + 0.5 * p1 * t * t / drag;
      tolerance = 1e-8;  // the closed form cancels by (drag t)^2 at 1e-3; rounding elsewhere
    }
    EXPECT_NEAR(stepper.velocity(0)[0] / v, 1.0, tolerance) << drag;
    EXPECT_NEAR(stepper.displacement(0)[0] / q, 1.0, tolerance) << drag;
    EXPECT_LT(std::abs(stepper.energy().imbalance()), 1e-12 * stepper.energy().input) << drag;  // rounding
    if (drag > 0.0) {
      EXPECT_GT(stepper.energy().body_dissipated, 0.0);
    }
  }
}

TEST(ModalStepperState, AFreeMassFliesStraightAndRebounds) {
  for (const ContactLaw kind : {ContactLaw::approach, ContactLaw::hard_stop}) {
    ContactForceLaw law{kind, 1e6, 0.0};
    law.restitution = 1.0;
    ModalStepper stepper({rigid_body(0.0)}, {wall(law, 1.0, {1.0})}, still);
    stepper.set_state(0, vector({0.0}), vector({2.0}));
    stepper.advance(1.0);
    // There in 0.5 s; the spring takes pi/omega = 3 ms to return it.
    EXPECT_NEAR(stepper.velocity(0)[0], -2.0, 1e-3 * 2.0);
    const double dwell = kind == ContactLaw::approach ? pi / 1e3 : 0.0;
    EXPECT_NEAR(stepper.displacement(0)[0], 1.0 - 2.0 * (0.5 - dwell), 1e-3);
    EXPECT_LT(std::abs(stepper.energy().imbalance()), 1e-12 * stepper.energy().initial);
  }
}

TEST(ModalStepperState, WhatFallsHasNoStaticRest) {
  ModalBody body = rigid_body(0.0);
  ModalStepper light({body}, {}, still);
  light.settle();
  light.advance(1.0);
  EXPECT_EQ(light.displacement(0)[0], 0.0);
  body.constant_load = vector({9.81});
  ModalStepper heavy({body}, {}, still);
  EXPECT_THROW(heavy.settle(), Error);
  heavy.advance(1.0);  // unless it is let fall
  EXPECT_NEAR(heavy.displacement(0)[0], 0.5 * 9.81, 1e-12);
}

TEST(ModalStepperState, RestHasItsOwnStiffnessAndStatesMayFollow) {
  // Stiffness 1e3 as it swings, 500 at rest.
  ModalBody body = oscillators({std::sqrt(1e3)}, 0.02);
  body.constant_load = vector({5.0});
  body.poles.rest_stiffness = vector({500.0});
  ModalStepper stepper({body}, {}, still);
  stepper.settle();
  stepper.advance(0.3);
  EXPECT_NEAR(stepper.displacement(0)[0], 0.01, 1e-15);
  EXPECT_NEAR(stepper.internal_force(0)[0], 5.0, 1e-12);
  EXPECT_NEAR(stepper.energy().imbalance(), 0.0, 1e-15);
  // A state set afterwards is held by the springs as they swing.
  stepper.set_state(0, vector({0.005}), vector({0.0}));
  stepper.advance(0.6);
  EXPECT_NEAR(stepper.displacement(0)[0], 0.005, 1e-15);
  EXPECT_NEAR(stepper.internal_force(0)[0], 5.0, 1e-12);
}

TEST(ModalStepperState, AWireThatLiesOnItsStopTakesLongSteps) {
  // Loaded with 3 m/s^2 sideways and 0.1 mm in the stop: settled, it stays without an event, and its steps
  // grow to the ladder's top, a sixteenth of the first period (which starts at a 1024th of it).
  Wb1Modal wb1;
  wb1.body.constant_load = -3.0 * wb1.body.load.col(2);
  wb1.stop.rest_offset[0] += wb1.stop.gap + 1e-4;
  for (const ContactLaw kind : {ContactLaw::approach, ContactLaw::no_adhesion, ContactLaw::hunt_crossley}) {
    wb1.stop.law = {kind, 1e5, 100.0, wb1.stop.gap};
    ModalStepper stepper({wb1.body}, {wb1.stop}, still);
    stepper.settle();
    const double force = stepper.force(0);
    EXPECT_GT(force, 0.0);
    stepper.advance(10.0);
    EXPECT_EQ(stepper.report().events, 0);
    EXPECT_LT(stepper.report().contact_steps, 10000);  // a thousand steps of top/1024 would last 2 ms
    EXPECT_NEAR(stepper.force(0), force, 1e-9 * force);
  }
}

TEST(ModalStepperState, StepsLiftedAtRestAreShortAgainWhenItRattles) {
  // The base glides for a second at the velocity with which WB-1 begins, then shakes: as accurate as without
  // the rest before.
  const Wb1Modal wb1;
  const double glide = testing::wb1_motion(0.0).velocity;
  const auto late = [glide](double t) {
    return t < 1.0 ? MotionSample{glide * (t - 1.0), glide, 0.0} : testing::wb1_motion(t - 1.0);
  };
  ModalBody body = wb1.body;
  ModalStepper stepper({body}, {wb1.stop}, late);
  stepper.advance(1.0);
  for (const testing::Wb1Value& value : testing::wb1_displacement) {
    stepper.advance(1.0 + value.time);
    // The tolerance of 1e-3 of the largest displacement, some 2 gaps.
    EXPECT_NEAR(stepper.offset(0)[0], value.displacement, 2e-3 * testing::wb1_gap) << value.time;
  }
}

}  // namespace
}  // namespace struna::fem
