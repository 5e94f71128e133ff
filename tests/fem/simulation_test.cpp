#include "fem/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "fem/error.hpp"
#include "fem/harmonic.hpp"
#include "tests/fem/filter_scene.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
constexpr double two_pi = 2.0 * std::numbers::pi;

/// Complex amplitude of column `x` at f over its second half.
Complex line(const Eigen::VectorXd& x, double f, double interval) {
  const long half = x.size() / 2;
  const Complex turn = std::polar(1.0, -two_pi * f * interval);
  Complex phase = 1.0, sum = 0.0;
  for (long n = half; n < x.size(); ++n, phase *= turn) sum += x[n] * phase;
  return sum;
}

TEST(Simulation, MultisineHasTheHarmonicTransferFunction) {
  for (const Body& body : {wire(), curved_wire()}) {
    const auto scene = bare_scene(body, Excitation::Kind::multisine, 1.0);
    const auto response = simulated(scene);
    EXPECT_TRUE(response.report.linear);
    const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(496, 10.0, 1000.0);
    const auto path = linear_path(scene);
    const Eigen::MatrixXcd exact =
        harmonic_response(assemble(path.body), path.drive, path.measurement, lines, {Damping::viscous, false})
            .response;
    const double largest_x = exact.col(0).cwiseAbs().maxCoeff();
    for (long k = 0; k < 3; ++k) {
      if (exact.col(k).cwiseAbs().maxCoeff() < 1e-6 * exact.col(1).cwiseAbs().maxCoeff())
        continue;  // straight: y only
      for (long i = 0; i < lines.size(); ++i) {
        const Complex measured = line(response.output.col(k), lines[i], response.sample_interval) /
                                 line(response.motion, lines[i], response.sample_interval);
        // The demand is 0.5 %; stepping is exact, what is left is the decay of the start, e^{-alpha/2 P}, and
        // modes cut off.
        EXPECT_LT(std::abs(measured / exact(i, k) - 1.0), 0.005) << k << ' ' << lines[i] << ' ' << largest_x;
      }
    }
  }
}

TEST(Simulation, NewmarkAgreesWithModalOnALinearScene) {
  auto scene = bare_scene(curved_wire(), Excitation::Kind::random, 0.03);
  // Of a point: the support's force also holds the ring of the sudden start at frequencies that no step
  // resolves.
  scene.measurement->at = BodyPoint{"wire", 0.4};
  scene.simulation->tolerance = 1e-6;  // so that modal is exact here
  const auto modal = simulated(scene);
  scene.simulation->method = IntegrationMethod::newmark;
  const auto distance = [&](double step) {
    scene.simulation->step = step;
    const auto newmark = simulated(scene);
    return (newmark.output - modal.output).norm() / modal.output.norm();
  };
  const double coarse = distance(1e-5);
  const double fine = distance(5e-6);
  EXPECT_LT(fine, 0.01);                             // (w dt)^2/12 of phase per radian, a hundred radians
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.15);  // second order; next term of the expansion
}

TEST(Simulation, StartsFromTheStaticShapeMovingWithTheBase) {
  // 1 Hz against a first mode at 28 Hz: the motion stays static. From rest instead, the start velocity of
  // -(a/w) would ring at 28 Hz with a force some hundred times the static one.
  auto scene = bare_scene(wire(), Excitation::Kind::sine, 0.2);
  scene.simulation->excitation.frequency_hz = 1.0;
  scene.simulation->excitation.acceleration = 0.1;
  const auto response = simulated(scene);
  const auto path = linear_path(scene);
  const Complex h = harmonic_response(assemble(path.body), path.drive, path.measurement,
                                      Eigen::VectorXd::Constant(1, 1.0), {Damping::viscous, false})
                        .response(0, 1);
  const double w = two_pi * 1.0;
  const double amplitude = 0.1 / (w * w);
  for (long n = 0; n < response.motion.size(); n += 50) {
    const double t = static_cast<double>(n) * response.sample_interval;
    const double steady = -amplitude * (h * std::polar(1.0, w * t)).imag();
    // Inertia and damping at the start: (1/28)^2 and alpha w/w1^2 of the force, and the dashpot's sudden
    // start: some percent.
    EXPECT_NEAR(response.output(n, 1), steady, 0.1 * amplitude * std::abs(h)) << t;
  }
}

TEST(Simulation, GravityRestsOnTheSupports) {
  auto scene = bare_scene(wire(), Excitation::Kind::sine, 0.05);
  scene.simulation->gravity = {0.0, 0.0, -9.81};
  const auto response = simulated(scene);
  const double half_weight = 0.5 * 7650.0 * 8.042477e-6 * 0.501 * 9.81;
  for (long n = 0; n < response.motion.size(); n += 100) {
    EXPECT_NEAR(response.output(n, 2), half_weight, 1e-6 * half_weight);  // rounding: nothing moves along z
  }
}

TEST(Simulation, AGapThatCannotCloseChangesNothing) {
  const auto bare = simulated(bare_scene(wire(), Excitation::Kind::random, 0.05));
  const auto scene = banded_scene(Excitation::Kind::random, 0.05, 0.1);
  const auto response = simulated(scene);
  EXPECT_TRUE(response.report.linear);
  EXPECT_GT(response.report.largest_offset, 0.0);
  EXPECT_LT(response.report.largest_offset, 0.2);
  EXPECT_TRUE(response.contacts.empty());
  // The same modes in shorter steps: the motion within a step is a polynomial, within the tolerance of 1e-3.
  EXPECT_LT((response.output - bare.output).norm(), 1e-3 * bare.output.norm());
}

TEST(Simulation, AContactThatClosesIsStepped) {
  const auto scene = banded_scene(Excitation::Kind::random, 0.05, 1.5e-4);
  const auto response = simulated(scene);
  EXPECT_FALSE(response.report.linear);
  EXPECT_GT(response.report.steps.events, 10);
  ASSERT_EQ(response.contacts.size(), 1U);
  const ContactMap& map = response.contacts.front();
  EXPECT_EQ(map.penetration.cols(), map.arc_length.size());
  EXPECT_GT(map.force.maxCoeff(), 0.0);
  EXPECT_TRUE((map.arc_length.array() >= 0.12 - 1e-9).all() &&
              (map.arc_length.array() <= 0.441 + 1e-9).all());
  ASSERT_TRUE(response.report.energy.has_value());
  EXPECT_LT(std::abs(response.report.energy->imbalance()), 1e-6 * std::abs(response.report.energy->input));
}

TEST(Simulation, IsCutShortOnDemand) {
  const auto scene = bare_scene(wire(), Excitation::Kind::random, 0.1);
  const auto response = simulate(scene, scene_motion(scene), [](double t) { return t < 0.05; });
  EXPECT_FALSE(response.report.complete);
  EXPECT_GT(response.motion.size(), 490);
  EXPECT_LT(response.motion.size(), 600);
  const auto whole = simulated(scene);
  const long kept = response.motion.size();
  // The same steps up to there.
  EXPECT_LT((whole.output.topRows(kept) - response.output).norm(), 1e-9 * whole.output.norm());
}

TEST(Simulation, FlagsWhatLeavesLinearTheory) {
  auto scene = bare_scene(wire(), Excitation::Kind::chirp, 0.2);
  scene.simulation->excitation.acceleration = 100.0;  // 25 mm at 10 Hz
  const auto response = simulated(scene);
  ASSERT_FALSE(response.report.warnings.empty());
  EXPECT_NE(response.report.warnings.front().find("linear beam theory"), std::string::npos);
  scene.simulation->excitation.acceleration = 1e-3;
  EXPECT_TRUE(simulated(scene).report.warnings.empty());
  // A curved wire is not stretched by its deflection, but it turns: 0.25 m at 10 Hz over 0.68 m.
  auto curved = bare_scene(curved_wire(), Excitation::Kind::chirp, 0.2);
  curved.simulation->excitation.acceleration = 1000.0;
  const auto turned = simulated(curved).report;
  ASSERT_FALSE(turned.warnings.empty());
  EXPECT_NE(turned.warnings.front().find("turns by"), std::string::npos);
  EXPECT_GT(turned.bodies.front().largest_slope, 0.2);
}

TEST(Simulation, TellsModesStepsAndTheEstimatedError) {
  auto scene = banded_scene(Excitation::Kind::random, 0.05, 1.5e-4);
  for (const double tolerance : {1e-2, 1e-3}) {
    scene.simulation->tolerance = tolerance;
    const auto report = simulated(scene).report;
    EXPECT_GT(report.estimated_error, 0.0);
    EXPECT_LE(report.estimated_error, tolerance);
    EXPECT_GT(report.error_checked_until, 0.0);
    EXPECT_GT(report.steps.modes, 0);
    EXPECT_GT(report.steps.shortest_step, 0.0);
  }
  scene.simulation->tolerance = 1e-2;
  EXPECT_GT(simulated(scene).report.steps.static_modes, 0);
}

TEST(Simulation, BodiesThatOverlapAsDrawnStartFromTheirEquilibrium) {
  // The wire lies 1 mm beside the bore's axis, the gap is 0.15 mm: it is bent into the bore before anything
  // moves.
  auto scene = banded_scene(Excitation::Kind::sine, 0.02, 1.5e-4);
  scene.bodies[1].centreline = straight_line({0.120, 1e-3, 0}, {0.441, 1e-3, 0});
  scene.simulation->excitation.acceleration = 1e-6;
  for (const auto method : {IntegrationMethod::modal, IntegrationMethod::newmark}) {
    scene.simulation->method = method;
    const auto response = simulated(scene);
    EXPECT_FALSE(response.report.linear);
    bool told = false;
    for (const auto& warning : response.report.warnings) {
      told = told || warning.find("equilibrium in contact") != std::string::npos;
    }
    EXPECT_TRUE(told);
    // At rest: the support's force stays what it is at the start (the base moves by 1e-11 m).
    const Eigen::VectorXd force = response.output.col(1);
    EXPECT_GT(std::abs(force[0]), 1e-3);
    // Newmark starts from its own static solution, banded: rounding. The filter's ripple of 1e-4 is common.
    EXPECT_LT((force.array() - force[0]).abs().maxCoeff(), 1e-3 * std::abs(force[0]));
  }
}

/// The curved wire and its concentric band, hanging in each other under gravity.
Scene hanging_scene(double gap, double stiffness, const Eigen::Vector3d& gravity) {
  auto scene = banded_scene(Excitation::Kind::sine, 0.003, gap);
  scene.bodies[0] = curved_wire();
  scene.bodies[1].centreline = scene.bodies[0].centreline;
  scene.bodies[0].elements = scene.bodies[1].elements = 16;
  scene.contacts[0].stiffness = stiffness;
  scene.simulation->excitation.acceleration = 1e-6;
  scene.simulation->gravity = gravity;
  scene.simulation->step = 1e-5;
  return scene;
}

TEST(Simulation, ACurvedWireRestsInItsBandUnderGravity) {
  // The free sag is a hundred times the smallest gap, and the wire gives more in some directions than in
  // others.
  for (const double stiffness : {1e3, 1e5}) {
    for (const double gap : {1e-5, 1e-4}) {
      for (const Eigen::Vector3d& gravity : {Eigen::Vector3d(0, 0, -9.81), Eigen::Vector3d(0, -9.81, 0)}) {
        auto scene = hanging_scene(gap, stiffness, gravity);
        const auto modal = simulated(scene);
        ASSERT_FALSE(modal.report.linear);
        scene.simulation->method = IntegrationMethod::newmark;
        const auto newmark = simulated(scene);
        const Eigen::RowVector3d rest = modal.output.row(0);
        EXPECT_GT(rest.norm(), 0.01);
        // It stays: the base moves by 3e-12 m. The anti-alias filter's ripple of 1e-4 acts on constants too.
        EXPECT_LT((modal.output.rowwise() - rest).cwiseAbs().maxCoeff(), 2e-4 * rest.norm());
        // Flexibility from all modes against that from the banded stiffness: rounding of the modal sum.
        EXPECT_LT((newmark.output.row(0) - rest).norm(), 1e-5 * rest.norm()) << gap << ' ' << stiffness;
      }
    }
  }
}

TEST(Simulation, SupportsOfBothBodiesCarryTheWeightOfBoth) {
  const Eigen::Vector3d gravity(1.0, -3.0, -9.81);
  auto scene = hanging_scene(2e-5, 1e5, gravity);
  Eigen::Vector3d carried = Eigen::Vector3d::Zero();
  double mass = 0.0;
  for (const Body& body : scene.bodies) {
    mass += body.density * body.section.area * body.centreline.length();
    for (const End end : {End::start, End::end}) {
      scene.measurement->at = Support{body.name, end};
      const auto response = simulated(scene);
      EXPECT_GT(response.report.steps.largest_penetration, 0.0);
      carried += response.output.row(0).transpose();
    }
  }
  // The arc is meshed by its chords' Hermite elements: 1e-4 of the mass, and the filter's ripple as much.
  EXPECT_LT((carried + mass * gravity).norm(), 1e-3 * mass * gravity.norm());
}

TEST(Simulation, ACurvedPairThatOverlapsAsDrawnStarts) {
  auto scene = hanging_scene(1.5e-4, 1e5, Eigen::Vector3d::Zero());
  auto moved = spline_through({{0, 5e-4, 0},
                               {0.18, 0.0605, 0.01},
                               {0.36, 0.0205, 0.09},
                               {0.52, -0.0495, 0.13},
                               {0.62, -0.0195, 0.16}},
                              0.68);
  scene.bodies[1].centreline = moved;
  for (const auto method : {IntegrationMethod::modal, IntegrationMethod::newmark}) {
    scene.simulation->method = method;
    const auto response = simulated(scene);
    const Eigen::RowVector3d rest = response.output.row(0);
    EXPECT_GT(rest.norm(), 1e-3);
    EXPECT_LT((response.output.rowwise() - rest).cwiseAbs().maxCoeff(), 2e-4 * rest.norm());
  }
}

TEST(Simulation, GravitySagIsEulersWhateverTheLossFactor) {
  auto scene = bare_scene(wire(), Excitation::Kind::multisine, 0.05);
  scene.measurement->at = BodyPoint{"wire", 0.5};
  scene.simulation->gravity = {0.0, -9.81, 0.0};
  scene.simulation->excitation.rms_acceleration = 1e-5;
  const double sag = 7650.0 * 8.042477e-6 * 9.81 * std::pow(0.501, 4) / (384.0 * 100e9 * 3.1083e-12);
  for (const double eta : {0.0, 0.01, 0.03, 0.1, 0.3}) {
    Material& material = scene.bodies[0].material;
    material.damping = Damping::structural;
    material.loss_factor = constant_law(eta);
    const auto response = simulated(scene);
    const Eigen::VectorXd y = response.output.col(1);
    EXPECT_NEAR(-y[0] / sag, 1.0, 1e-3) << eta;  // modes left to statics, (f/f_r)^2; 25 elements are exact
    // And no creep: it stays, up to the vibration, 1e-5 m/s^2 at 40 Hz and more.
    EXPECT_LT((y.array() - y[0]).abs().maxCoeff(), 1e-3 * sag) << eta;
  }
}

/// Both ends turn freely: a straight wire about itself, a curved one swings about its chord.
Scene pinned_scene(bool curved, double gap) {
  auto scene = banded_scene(Excitation::Kind::sine, 0.02, gap);
  if (curved) {
    scene.bodies[0] = curved_wire();
    scene.bodies[1].centreline = scene.bodies[0].centreline;
  }
  scene.bodies[0].start = scene.bodies[0].end = EndCondition::pinned;
  scene.simulation->excitation.acceleration = 100.0;
  return scene;
}

TEST(Simulation, PinnedEndsRunWithMassProportionalDamping) {
  auto scene = pinned_scene(false, 1.0);
  // Of a point: the support's force also holds the ring of the start, which Newmark's step does not resolve.
  scene.measurement->at = BodyPoint{"wire", 0.4};
  scene.simulation->tolerance = 1e-6;
  const auto modal = simulated(scene);
  EXPECT_TRUE(modal.report.linear);
  scene.simulation->method = IntegrationMethod::newmark;
  scene.simulation->step = 1e-5;
  const auto newmark = simulated(scene);
  // (w dt)^2/12 of phase per radian, at 50 Hz over a few radians, and of the ring above it.
  EXPECT_LT((modal.output.col(1) - newmark.output.col(1)).norm(), 2e-3 * newmark.output.col(1).norm());
}

TEST(Simulation, AWireThatSwingsInItsBandRunsAndClosesItsLedger) {
  for (const auto damping : {Damping::structural, Damping::viscous}) {
    for (const ContactLaw law : {ContactLaw::approach, ContactLaw::hard_stop}) {
      auto scene = pinned_scene(true, 1e-4);
      scene.bodies[0].material.loss_factor = constant_law(0.03);
      scene.bodies[0].material.damping = damping;
      scene.contacts[0].law = law;
      scene.simulation->duration = 0.01;
      scene.simulation->step = 2e-5;
      const auto response = simulated(scene);
      EXPECT_FALSE(response.report.linear);
      ASSERT_TRUE(response.report.energy.has_value());
      EXPECT_LT(std::abs(response.report.energy->imbalance()),
                1e-6 * std::abs(response.report.energy->input));
    }
  }
}

TEST(Simulation, GravityThatMakesABodySwingIsRefusedByName) {
  auto scene = pinned_scene(true, 1e-4);
  scene.contacts.clear();
  scene.bodies.pop_back();
  scene.simulation->gravity = {0.0, 0.0, -9.81};
  try {
    simulated(scene);
    FAIL() << "a swinging wire was given a static rest";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("'wire'"), std::string::npos) << error.what();
  }
}

TEST(Simulation, EveryContactLawRunsAndClosesItsLedger) {
  for (const ContactLaw law :
       {ContactLaw::approach, ContactLaw::no_adhesion, ContactLaw::hunt_crossley, ContactLaw::hard_stop}) {
    auto scene = banded_scene(Excitation::Kind::random, 0.05, 1.5e-4);
    scene.contacts[0].law = law;
    scene.contacts[0].restitution = 0.5;
    scene.simulation->tolerance = 1e-2;  // with modes left to statics
    const auto response = simulated(scene);
    EXPECT_GT(response.report.steps.static_modes, 0);
    EXPECT_GT(response.report.steps.events, 10);
    ASSERT_TRUE(response.report.energy.has_value());
    EXPECT_LT(std::abs(response.report.energy->imbalance()), 1e-6 * std::abs(response.report.energy->input))
        << static_cast<int>(law);
    EXPECT_GT(response.report.energy->contact_dissipated, 0.0);
  }
}

TEST(Simulation, ABandOutsideTheWiresReachIsToldToDoNothing) {
  auto scene = banded_scene(Excitation::Kind::random, 0.02, 1.5e-4);
  scene.bodies[1].centreline = straight_line({0.6, 0, 0}, {0.9, 0, 0});  // beyond the wire's end
  const auto response = simulated(scene);
  EXPECT_TRUE(response.report.linear);
  ASSERT_FALSE(response.report.warnings.empty());
  EXPECT_NE(response.report.warnings.front().find("can do nothing"), std::string::npos);
}

TEST(Simulation, AGapSmallerThanTheSagittaNeverTouchesAtRest) {
  // Concentric curved bodies of different meshes: the sagitta of the wire's elements is 0.5 mm, the gap 10
  // um.
  auto scene = banded_scene(Excitation::Kind::sine, 0.01, 1e-5);
  scene.bodies[0] = curved_wire();
  scene.bodies[1].centreline = scene.bodies[0].centreline;
  scene.simulation->excitation.acceleration = 1e-6;
  const auto response = simulated(scene);
  EXPECT_TRUE(response.report.linear);
  EXPECT_LT(response.report.largest_offset, 1e-3);
}

TEST(Simulation, FixedModalStepsBeyondTheLooksAreCheckedAsTheyAreTaken) {
  auto scene = banded_scene(Excitation::Kind::random, 0.05, 2e-5);
  scene.contacts[0].damping = 1.0;
  scene.contacts[0].stiffness = 1e4;
  scene.simulation->contact_substeps = 1;
  const auto error_at = [&](double step) {
    scene.simulation->step = step;
    return simulated(scene).report.estimated_error;
  };
  const double taken = error_at(2.5e-5), asked = error_at(1e-4);
  EXPECT_GT(taken, 1e-5);
  EXPECT_NEAR(asked / taken, 1.0, 0.5);  // was a thousandth: a run against itself
}

TEST(Simulation, NewmarkRunsARecordToItsEnd) {
  // Its last sample lies an interval before the duration.
  auto scene = bare_scene(wire(), Excitation::Kind::random, 0.02);
  scene.simulation->method = IntegrationMethod::newmark;
  scene.simulation->step = 1e-5;
  scene.simulation->sample_rate = 10000.0;
  const Eigen::VectorXd samples = 1e-5 * (0.06 * Eigen::ArrayXd::LinSpaced(200, 0.0, 199.0)).sin();
  const TimeResponse response = simulate(scene, motion_from_samples(samples, 1e-4));
  EXPECT_EQ(response.output.rows(), 200);
}

TEST(Simulation, PenetrationDeeperThanTheGapIsFlagged) {
  auto scene = banded_scene(Excitation::Kind::random, 0.05, 2e-5);
  scene.contacts[0].stiffness = 10.0;
  scene.contacts[0].damping = 0.0;
  bool told = false;
  for (const auto& warning : simulated(scene).report.warnings) {
    told = told || warning.find("too low to stand for a wall") != std::string::npos;
  }
  EXPECT_TRUE(told);
}

TEST(Simulation, ContactThatIsTooStiffIsAnError) {
  auto scene = banded_scene(Excitation::Kind::random, 0.05, 1.5e-4);
  scene.contacts[0].stiffness = 1e18;
  EXPECT_THROW(simulated(scene), Error);
}

TEST(Simulation, ModalAndNewmarkAgreeOnTheFilter) {
  // Gap 6.5e-4 m over 50 ms, 5e-5 m over 20 ms: 1 % of the peak displacement of a point of the wire.
  for (const auto& [gap, duration] : {std::pair{6.5e-4, 0.05}, std::pair{5e-5, 0.02}}) {
    auto scene = banded_scene(Excitation::Kind::sine, duration, gap);
    scene.bodies[1].material = viscous_material(30e9);
    scene.simulation->excitation.frequency_hz = 100.0;
    scene.simulation->excitation.acceleration = 400.0;  // a base motion of 1 mm
    scene.measurement->at = BodyPoint{"wire", 0.5};
    const auto modal = simulated(scene);
    EXPECT_FALSE(modal.report.linear) << gap;
    scene.simulation->method = IntegrationMethod::newmark;
    scene.simulation->step = 2e-6;
    const auto newmark = simulated(scene);
    const Eigen::VectorXd difference = modal.output.col(1) - newmark.output.col(1);
    // First order in Newmark's step after touch (WB-1: 1e-4 of the gap at 1e-6 s, 6e-3 at 2e-5 s).
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.01 * modal.output.col(1).cwiseAbs().maxCoeff()) << gap;
  }
}

TEST(Simulation, RefusesWhatItCannotDo) {
  const auto scene = bare_scene(wire(), Excitation::Kind::sine, 0.01);
  auto fault = scene;
  fault.drive.reset();
  EXPECT_THROW(simulated(fault), Error);
  fault = scene;
  fault.measurement.reset();
  EXPECT_THROW(simulated(fault), Error);
  fault = scene;
  fault.simulation.reset();
  EXPECT_THROW(scene_motion(fault), Error);
  EXPECT_THROW(simulate(fault, scene_motion(scene)), Error);
  fault = scene;
  fault.simulation->excitation.kind = Excitation::Kind::record;
  EXPECT_THROW(scene_motion(fault), Error);
  fault = scene;
  fault.drive->at = BodyPoint{"wire", 0.5};
  EXPECT_THROW(scene_motion(fault), Error);  // accelerations do not describe a force
  fault = scene;
  fault.simulation->duration = 0.02;
  EXPECT_THROW(simulate(fault, scene_motion(scene)), Error);  // motion too short
  fault = banded_scene(Excitation::Kind::sine, 0.01, 1e-3);
  fault.contacts.clear();
  fault.drive->at = Support{"band", End::start};
  EXPECT_THROW(simulated(fault), Error);  // nothing moves the wire
  fault = scene;
  fault.simulation->method = IntegrationMethod::newmark;
  fault.bodies[0].material.damping = Damping::structural;
  fault.bodies[0].material.loss_factor = constant_law(0.03);
  EXPECT_THROW(simulated(fault), Error);
}

}  // namespace
}  // namespace struna::fem
