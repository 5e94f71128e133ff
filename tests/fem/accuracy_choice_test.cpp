#include "fem/accuracy_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "fem/error.hpp"
#include "fem/simulation_plan.hpp"

namespace struna::fem {
namespace {

Body wire(int elements) {
  Body body{"wire",
            straight_line({0, 0, 0}, {0.501, 0, 0}),
            {8.042477e-6, 3.1083e-12, 6.2166e-12},
            7650.0,
            0.3,
            {},
            elements,
            EndCondition::clamped,
            EndCondition::clamped};
  body.material.youngs_modulus = constant_law(100e9);
  body.material.rayleigh = {43.1, 2e-6};
  body.material.damping = Damping::viscous;
  return body;
}

Body band(int elements) {
  Body body = wire(elements);
  body.name = "band";
  body.centreline = straight_line({0.12, 0, 0}, {0.441, 0, 0});
  body.section = {6.126106e-5, 3.9245e-10, 7.849e-10};
  body.density = 4535.0;
  body.material.youngs_modulus = constant_law(30e9);
  return body;
}

Scene scene_of(const Body& inside, const Body& outside, double gap, ContactLaw law = ContactLaw::approach) {
  Scene scene;
  scene.bodies = {inside, outside};
  scene.drive = SceneDrive{Support{"wire", End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement = SceneMeasurement{
      Support{"wire", End::end}, MotionQuantity::displacement, {"force_y"}, {Eigen::Vector3d::UnitY()}};
  scene.contacts = {{"wire", "band", gap, 1e5, 100.0, law}};
  scene.simulation = Simulation{};
  scene.simulation->duration = 0.1;
  return scene;
}

/// A scene made ready, and its motion.
struct Case {
  explicit Case(const Scene& s, const Excitation& excitation, double highest) : highest_hz(highest) {
    scene = std::make_unique<Scene>(s);
    plan = plan_simulation(*scene, highest_hz);
    for (const PlannedBody& body : plan.bodies) {
      bodies.push_back(modal_body(body.model, body.modes, body.coordinates, body.drive, highest_hz));
    }
    const MotionHistory history = motion_history(excitation, 0.1);
    motion = [history](double t) { return history.at(t); };
  }
  std::unique_ptr<Scene> scene;
  double highest_hz;
  SimulationPlan plan;
  std::vector<ModalBody> bodies;
  PrescribedMotion motion;
};

Excitation sine() {
  Excitation excitation;
  excitation.kind = Excitation::Kind::sine;
  excitation.frequency_hz = 200.0;
  excitation.acceleration = 100.0;
  return excitation;
}

Excitation random_motion() {
  Excitation excitation;
  excitation.band_lo_hz = 10.0;
  excitation.band_hi_hz = 1000.0;
  excitation.rms_acceleration = 20.0;
  return excitation;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  all.emplace_back(scene_of(wire(25), band(16), 5e-5), sine(), 200.0);
  all.emplace_back(scene_of(wire(40), band(26), 5e-5, ContactLaw::no_adhesion), sine(), 200.0);
  all.emplace_back(scene_of(wire(25), band(16), 1.5e-4), random_motion(), 1000.0);
  Body curved = wire(12);
  curved.centreline = spline_through(
      {{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}, {0.52, -0.05, 0.13}, {0.62, -0.02, 0.16}}, 0.68);
  Body around = band(12);
  around.centreline = curved.centreline;
  all.emplace_back(scene_of(curved, around, 1.5e-4), random_motion(), 1000.0);
  return all;
}

std::vector<Eigen::Vector2d> path(const Case& c, const ModalSteppingOptions& options,
                                  const AccuracyChoice& choice, StepReport& report) {
  ModalStepper stepper(c.bodies, c.plan.points, c.motion, options);
  std::vector<Eigen::Vector2d> offsets;
  for (int look = 0; look * 3.3e-5 <= choice.checked_until; ++look) {
    stepper.advance(look * 3.3e-5);
    for (std::size_t i = 0; i < c.plan.points.size(); ++i) {
      offsets.push_back(stepper.offset(static_cast<int>(i)));
    }
  }
  report = stepper.report();
  return offsets;
}

TEST(AccuracyChoice, TheErrorAgainstARefinedRunIsWithinTheTolerance) {
  bool first = true;
  for (const Case& c : cases()) {
    int modes_before = 0;
    std::vector<Eigen::Vector2d> reference;
    StepReport refined;
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
      ModalSteppingOptions options;
      options.tolerance = tolerance;
      const AccuracyChoice choice =
          choose_accuracy(c.bodies, c.plan.points, c.motion,
                          first_cut_hz(c.highest_hz, options.tolerance, true), 0.1, options, false);
      EXPECT_LE(choice.estimated_error, tolerance);
      EXPECT_EQ(choice.known_until, choice.checked_until);
      EXPECT_GT(choice.checked_until, choice.checked_from);
      // Every mode, far finer. The first case by fixed steps of 1e-7 s in contact (1/90 of m/c, second
      // order), so that the step control has no part in it.
      ModalSteppingOptions fine;
      fine.tolerance = 1e-6;
      if (first) fine.step = 2e-6, fine.contact_substeps = 20;
      if (reference.empty()) reference = path(c, fine, choice, refined);
      EXPECT_GT(refined.events, 2);
      StepReport report;
      options.tolerance = choice.tolerance;
      options.highest_mode_hz = choice.highest_mode_hz;
      const auto chosen = path(c, options, choice, report);
      ASSERT_EQ(chosen.size(), reference.size());
      double worst = 0.0;
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        worst = std::max(worst, (chosen[i] - reference[i]).cwiseAbs().maxCoeff());
      }
      EXPECT_LT(worst / refined.largest_displacement, tolerance) << report.modes;
      // The estimate is honest: between its looks, and by its reference's own error (at most a tenth), the
      // true one may be larger; measured up to 2.8 times.
      EXPECT_LT(worst / refined.largest_displacement, 3.0 * choice.estimated_error + 0.1 * tolerance);
      EXPECT_GE(report.modes, modes_before);  // a tighter tolerance keeps as many modes or more
      modes_before = report.modes;
    }
    first = false;
  }
}

TEST(AccuracyChoice, WherePathsPartTheErrorIsToldAndUntilWhenTheyAreKnown) {
  // A hard, hardly damped band: what a step leaves grows a hundredfold in 20 ms, and errors fall with the
  // 0.4th power of the tolerance only.
  Scene scene = scene_of(wire(16), band(10), 1.5e-4);
  scene.contacts[0].stiffness = 1e6;
  scene.contacts[0].damping = 1.0;
  Excitation shaken = sine();
  shaken.frequency_hz = 150.0;
  shaken.acceleration = 200.0;
  const Case c(scene, shaken, 150.0);
  ModalSteppingOptions options;
  options.tolerance = 1e-3;
  const AccuracyChoice choice = choose_accuracy(c.bodies, c.plan.points, c.motion,
                                                first_cut_hz(150.0, 1e-3, true), 0.1, options, false);
  EXPECT_GT(choice.estimated_error, options.tolerance);
  EXPECT_GT(choice.known_until, choice.checked_from);
  EXPECT_LT(choice.known_until, choice.checked_until);
  ModalSteppingOptions fine;
  fine.tolerance = 1e-8;
  ModalStepper reference(c.bodies, c.plan.points, c.motion, fine);
  options.tolerance = choice.tolerance;
  options.highest_mode_hz = choice.highest_mode_hz;
  ModalStepper chosen(c.bodies, c.plan.points, c.motion, options);
  double known = 0.0, all = 0.0;
  for (int look = 0; look * 2.5e-5 <= choice.checked_until; ++look) {
    chosen.advance(look * 2.5e-5);
    reference.advance(look * 2.5e-5);
    for (int i = 0; i < static_cast<int>(c.plan.points.size()); ++i)
      all = std::max(all, (chosen.offset(i) - reference.offset(i)).cwiseAbs().maxCoeff());
    if (look * 2.5e-5 <= choice.known_until) known = all;
  }
  const double largest = reference.report().largest_displacement;
  EXPECT_LE(known / largest, 1e-3);
  // Measured over the map of docs/limits.md: the estimate is 1.1 to 1.3 times the error.
  EXPECT_GT(choice.estimated_error, all / largest);
  EXPECT_LT(choice.estimated_error, 2.0 * all / largest);
}

TEST(AccuracyChoice, ALooseToleranceIsTriedBelowOne) {
  Scene scene = scene_of(wire(12), band(8), 5e-5);
  const Case c(scene, sine(), 200.0);
  ModalSteppingOptions options;
  options.tolerance = 0.4;  // four times that is no tolerance
  const AccuracyChoice choice =
      choose_accuracy(c.bodies, c.plan.points, c.motion, first_cut_hz(200.0, 0.4, true), 0.1, options, false);
  EXPECT_LE(choice.tolerance, 0.5);
  EXPECT_LE(choice.estimated_error, 0.4);
}

TEST(AccuracyChoice, LeavesModesToStaticsWhereTheToleranceAllows) {
  const std::vector<Case> all = cases();
  const Case& fine_mesh = all[1];
  const auto modes = [&](double tolerance) {
    ModalSteppingOptions options;
    options.tolerance = tolerance;
    const AccuracyChoice choice =
        choose_accuracy(fine_mesh.bodies, fine_mesh.plan.points, fine_mesh.motion,
                        first_cut_hz(fine_mesh.highest_hz, tolerance, true), 0.1, options, false);
    options.highest_mode_hz = choice.highest_mode_hz;
    const ModalStepper stepper(fine_mesh.bodies, fine_mesh.plan.points, fine_mesh.motion, options);
    return stepper.report().modes;
  };
  ModalSteppingOptions every;
  const ModalStepper stepper(fine_mesh.bodies, fine_mesh.plan.points, fine_mesh.motion, every);
  EXPECT_LT(modes(1e-2), stepper.report().modes / 2);
  EXPECT_LT(modes(1e-3), stepper.report().modes);
}

TEST(AccuracyChoice, StaticModesCarryConstantLoads) {
  // A clamped wire under its weight, most modes left to statics: the sag is that of every mode.
  Scene scene = scene_of(wire(25), band(16), 1.5e-4);
  scene.simulation->gravity = {0.0, -9.81, 0.0};
  const Case c(scene, sine(), 200.0);
  const auto sag = [&](double highest_mode_hz) {
    ModalSteppingOptions options;
    options.highest_mode_hz = highest_mode_hz;
    ModalStepper stepper(
        c.bodies, c.plan.points, [](double) { return MotionSample{}; }, options);
    stepper.settle();
    double deepest = -1.0;
    for (std::size_t i = 0; i < c.plan.points.size(); ++i) {
      deepest = std::max(deepest, stepper.penetration(static_cast<int>(i)));
    }
    EXPECT_GT(deepest, 0.0);  // the weight presses it into the bore
    return stepper.offset(2)[0];
  };
  const double exact = sag(0.0);
  EXPECT_NEAR(sag(100.0), exact, 1e-9 * std::abs(exact));  // rounding of the modal sums
}

}  // namespace
}  // namespace struna::fem
