#include "fem/modal_stepping.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <random>

#include "fem/error.hpp"
#include "oscillators.hpp"
#include "wb1.hpp"

namespace struna::fem {
namespace {

using testing::free_mass;
using testing::mass_in_bore;
using testing::oscillators;
using testing::still;
using testing::vector;
using testing::wall;
using testing::Wb1Modal;
constexpr double pi = std::numbers::pi;

/// Rebound speed over approach speed of a lone mass of 1 kg thrown at a wall with v.
double rebound(const ContactForceLaw& law, double speed, double duration,
               const ModalSteppingOptions& options) {
  ModalStepper stepper({free_mass()}, {wall(law, 0.0, {1.0})}, still, options);
  stepper.set_state(0, vector({-1e-3 * speed}), vector({speed}));
  stepper.advance(duration);
  EXPECT_LT(stepper.penetration(0), 0.0);
  return -stepper.velocity(0)[0] / speed;
}

TEST(ModalStepping, LoneMassReboundsAsTheLawsClosedFormSays) {
  const double k = 1e6;  // m = 1: omega = 1000, contact lasts about 3 ms
  ModalSteppingOptions options;
  options.step = 2e-5;
  options.contact_substeps = 20;  // omega h = 1e-3
  for (const double zeta : {.01, .05, .1, .2, .3, .5, 1 / std::sqrt(2.0), .9, 2.0, 4.09, 5.334}) {
    const double c = 2.0 * zeta * 1000.0;
    const double last = 0.02 + 0.03 * std::max(1.0, zeta);  // long tails when overdamped
    // Second order in h/(shortest time of the motion): (omega h max(1, 2 zeta))^2, times a few.
    const double tolerance = 1e-6 * std::max(1.0, 4.0 * zeta * zeta);
    EXPECT_NEAR(rebound({ContactLaw::no_adhesion, k, c}, 0.5, last, options), no_adhesion_restitution(zeta),
                tolerance)
        << zeta;
    EXPECT_NEAR(rebound({ContactLaw::approach, k, c}, 0.5, last, options), approach_restitution(zeta),
                tolerance)
        << zeta;
    // l = v/omega makes the relative damping c v/(k l) = 2 zeta.
    EXPECT_NEAR(rebound({ContactLaw::hunt_crossley, k, c, 0.5e-3}, 0.5, last, options),
                hunt_crossley_restitution(2.0 * zeta), tolerance)
        << zeta;
  }
}

TEST(ModalStepping, HardStopReboundsWithItsRestitution) {
  ModalSteppingOptions options;
  options.step = 1e-4;
  ContactForceLaw law{ContactLaw::hard_stop, 1e6, 0.0};
  for (const double r : {0.0, 0.3, 0.8, 1.0}) {
    law.restitution = r;
    ModalStepper stepper({free_mass()}, {wall(law, 0.0, {1.0})}, still, options);
    stepper.set_state(0, vector({-0.01234}), vector({1.0}));
    stepper.advance(0.02);
    // The weak spring (omega = 0.01) changes the speed by omega^2 x t < 1e-7.
    EXPECT_NEAR(stepper.velocity(0)[0], -r, 1e-7);
    EXPECT_NEAR(stepper.events().front().time, 0.01234, 1e-8);
    EXPECT_NEAR(stepper.energy().imbalance(), 0.0, 1e-12);
  }
}

TEST(ModalStepping, ShawHolmesOrbitsArePeriodic) {
  // x'' + 2 z x' + x = cos(w t), stop at xc, v+ = -r v-: one impact per period (J. Sound Vib. 90 (1983) 129).
  struct Orbit {
    double w, z, r, xc, phase, speed;
  };
  for (const Orbit& o : {Orbit{2.6, 0.0, 0.8, 0.0, 3.02938293575398, .505439970893957},
                         Orbit{2.0, 0.05, 0.7, 0.1, 1.82492971297879, 2.91529390842934}}) {
    ModalBody body = oscillators({1.0}, o.z);
    body.load(0, 0) = 1.0;
    const auto force = [&](double t) {
      const double p = o.w * t + o.phase;
      return MotionSample{std::cos(p), -o.w * std::sin(p), -o.w * o.w * std::cos(p)};
    };
    ContactForceLaw law{ContactLaw::hard_stop, 1e4, 0.0};
    law.restitution = o.r;
    ModalSteppingOptions options;
    options.step = 2.0 * pi / o.w / 2000.0;  // the cubic for the load: (w h)^4/720 = 1e-13
    ModalStepper stepper({body}, {wall(law, o.xc, {1.0})}, force, options);
    // Just after the impact at t = 0.
    stepper.set_state(0, vector({o.xc}), vector({-o.r * o.speed}));
    stepper.advance(3.02 * 2.0 * pi / o.w);
    ASSERT_EQ(stepper.events().size(), 3u);
    for (int i = 0; i < 3; ++i) {
      const ContactEvent& event = stepper.events()[static_cast<std::size_t>(i)];
      EXPECT_EQ(event.kind, ContactEvent::Kind::impact);
      // The given digits (1e-14), the events' slack (1e-9 of a period at speed 1) and three periods' growth
      // of both.
      EXPECT_NEAR(event.time, (i + 1) * 2.0 * pi / o.w, 1e-7);
      EXPECT_NEAR(event.rate, o.speed, 1e-7);
    }
  }
}

TEST(ModalStepping, FreeFlightIsExactWithoutLoadAtAnyStep) {
  ModalSteppingOptions options;
  options.step = 0.37;  // several periods
  ModalStepper stepper({oscillators({50.0}, 0.01)}, {}, still, options);
  stepper.set_state(0, vector({1.0}), vector({0.0}));
  stepper.advance(2.0);
  const double s = 0.5, d = 50.0 * std::sqrt(1.0 - 1e-4);
  const double expected = std::exp(-s * 2.0) * (std::cos(2.0 * d) + s / d * std::sin(2.0 * d));
  EXPECT_NEAR(stepper.displacement(0)[0], expected, 1e-13);  // rounding over six steps
}

TEST(ModalStepping, SmoothLoadIsFollowedAtFourthOrder) {
  // Resonator under u'': closed form of the steady state plus transient is avoided by halving the step.
  const auto end = [](double step) {
    ModalBody body = oscillators({300.0}, 0.02);
    body.load(0, 2) = -1.0;
    ModalSteppingOptions options;
    options.step = step;
    const auto motion = [](double t) {
      const double w = 400.0;
      return MotionSample{std::cos(w * t), -w * std::sin(w * t), -w * w * std::cos(w * t)};
    };
    ModalStepper stepper({body}, {}, motion, options);
    stepper.advance(0.1);
    return stepper.displacement(0)[0];
  };
  const double h = 0.1 / 64;
  const double order = std::log2(std::abs((end(h) - end(h / 2)) / (end(h / 2) - end(h / 4))));
  EXPECT_NEAR(order, 4.0, 0.2);
}

TEST(ModalStepping, Wb1ReachesTheReferenceAndItsEventTimes) {
  const Wb1Modal wb1;
  ModalSteppingOptions options;
  options.step = 5e-5;
  options.contact_substeps = 20;
  ModalStepper stepper = wb1.stepper(options);
  for (const testing::Wb1Value& value : testing::wb1_displacement) {
    stepper.advance(value.time);
    // Discretisation in time; measured 1e-5 of the gap at this step. The demand is 2e-4.
    EXPECT_NEAR(stepper.offset(0)[0], value.displacement, 4e-5 * testing::wb1_gap) << value.time;
  }
  EXPECT_EQ(stepper.report().events, 55);
  EXPECT_EQ(stepper.report().modes, 54);  // one plane: 27 nodes with v and rz
  EXPECT_TRUE(stepper.report().planar);
  using Kind = ContactEvent::Kind;
  const std::vector<std::pair<double, Kind>> expected = {
      {.031531762201, Kind::touch},         {.033597938361, Kind::force_ends},
      {.033600989578, Kind::force_resumes}, {.034429915846, Kind::force_ends},
      {.034729683934, Kind::open},          {.035735640974, Kind::touch}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(stepper.events()[i].kind, expected[i].second) << i;
    EXPECT_NEAR(stepper.events()[i].time, expected[i].first, 1e-6) << i;
  }
  EXPECT_NEAR(stepper.events()[0].rate, .405534783, 1e-7);
  const EnergyLedger energy = stepper.energy();
  EXPECT_LT(std::abs(energy.imbalance()), 1e-12 * energy.input);  // rounding over some 20 000 steps
  EXPECT_GT(energy.contact_dissipated, 0.01 * energy.input);
  EXPECT_GT(energy.body_dissipated, 0.01 * energy.input);
}

TEST(ModalStepping, Wb1ConvergesAtSecondOrderInTheStep) {
  const Wb1Modal wb1;
  const auto worst = [&](double step) {
    ModalSteppingOptions options;
    options.step = step;
    options.contact_substeps = 10;
    ModalStepper stepper = wb1.stepper(options);
    double error = 0.0;
    for (const testing::Wb1Value& value : testing::wb1_displacement) {
      stepper.advance(value.time);
      error = std::max(error, std::abs(stepper.offset(0)[0] - value.displacement));
    }
    return error;
  };
  const double coarse = worst(1e-4), middle = worst(5e-5), fine = worst(2.5e-5);
  EXPECT_NEAR(std::log2(coarse / middle), 2.0, 0.2);
  EXPECT_NEAR(std::log2(middle / fine), 2.0, 0.2);
}

TEST(ModalStepping, Wb1MeetsTheToleranceAsked) {
  const Wb1Modal wb1;
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    ModalSteppingOptions options;
    options.tolerance = tolerance;
    ModalStepper stepper = wb1.stepper(options);
    for (const testing::Wb1Value& value : testing::wb1_displacement) {
      stepper.advance(value.time);
      EXPECT_NEAR(stepper.offset(0)[0], value.displacement, tolerance * stepper.report().largest_displacement)
          << "tolerance " << tolerance << " at " << value.time;
    }
  }
}

TEST(ModalStepping, ElasticStopsConserveEnergyOverAHundredThousandContacts) {
  // Two undamped oscillators between which the gap moves; the contact excites both, chaotically.
  ModalSteppingOptions options;
  options.step = 2.0 * pi / 40.0;  // coarse: conservation is to hold at any step
  options.contact_substeps = 2;
  options.keep_events = false;
  ModalStepper stepper({oscillators({1.0, 2.7}, 0.0)},
                       {wall({ContactLaw::no_adhesion, 400.0, 0.0}, 0.05, {0.8, 0.6})}, still, options);
  stepper.set_state(0, vector({-1.0, 0.3}), vector({0.2, -0.5}));
  const double initial = stepper.energy().initial;
  long contacts = 0;
  for (double t = 1000.0; contacts < 200000; t += 1000.0) {  // touch and open are two events
    stepper.advance(t);
    contacts = stepper.report().events;
    ASSERT_LT(t, 2e6);
  }
  const EnergyLedger energy = stepper.energy();
  // A point leaves with g up to the events' slack (1e-6 of a step) times its speed: k g^2/2 = 1e-12 each, 1e5
  // times.
  EXPECT_NEAR((energy.kinetic + energy.strain + energy.contact_stored) / initial, 1.0, 1e-7);
}

TEST(ModalStepping, RollingInABoreKeepsEnergyWithTurningNormals) {
  ModalSteppingOptions options;
  options.step = 2e-5;
  options.contact_substeps = 2;
  ModalStepper stepper = mass_in_bore({ContactLaw::approach, 1e6, 0.0}, options);
  stepper.set_state(0, vector({0.9e-3, 0.0}), vector({0.1, 0.4}));
  stepper.advance(2.0);
  EXPECT_FALSE(stepper.report().planar);
  EXPECT_GT(stepper.report().events, 500);
  const EnergyLedger energy = stepper.energy();
  EXPECT_NEAR((energy.kinetic + energy.strain + energy.contact_stored) / energy.initial, 1.0, 1e-10);
  EXPECT_LE(stepper.offset(0).norm(), 1e-3 + stepper.report().largest_penetration + 1e-12);
}

TEST(ModalStepping, BoreDampsWithALedgerThatCloses) {
  for (const ContactLaw kind : {ContactLaw::approach, ContactLaw::no_adhesion, ContactLaw::hunt_crossley}) {
    ModalSteppingOptions options;
    options.step = 5e-5;
    ModalStepper stepper = mass_in_bore({kind, 1e6, 200.0, 1e-3}, options);
    stepper.set_state(0, vector({0.9e-3, 0.0}), vector({0.1, 0.4}));
    stepper.advance(0.2);
    const EnergyLedger energy = stepper.energy();
    EXPECT_GT(energy.contact_dissipated, 0.1 * energy.initial);
    // Rounding, and the forces' own convergence to 1e-14.
    EXPECT_LT(std::abs(energy.imbalance()), 1e-11 * energy.initial);
  }
}

TEST(ModalStepping, PlanarMotionIsSolvedInItsPlaneAndEqualsTheFullOne) {
  // A wire's two planes; motion along a slanted direction stays on a line.
  const Wb1Modal wb1;
  ModalSteppingOptions options;
  options.step = 1e-4;
  ContactPoint bore = wb1.stop;
  bore.shape = StopShape::bore;
  ModalStepper planar({wb1.body}, {bore}, testing::wb1_motion, options);
  // A whisper across the plane keeps every component of every point alive.
  ContactPoint tilted = bore;
  tilted.inside.col(1) = 1e-8 * tilted.inside.col(0).reverse();
  ModalStepper full({wb1.body}, {tilted}, testing::wb1_motion, options);
  planar.advance(0.06);
  full.advance(0.06);
  EXPECT_TRUE(planar.report().planar);
  EXPECT_FALSE(full.report().planar);
  EXPECT_GT(planar.report().events, 0);
  EXPECT_EQ(planar.report().idle_modes, wb1.body.poles.modes - 54);
  // The tilt of 1e-8 turns the force by as much.
  EXPECT_NEAR(planar.offset(0)[0], full.offset(0)[0], 1e-6 * testing::wb1_gap);
}

TEST(ModalStepping, DeepPenetrationIsFollowed) {
  // Far deeper than the gap: the law has no bottom, and the direction stays defined.
  ModalSteppingOptions options;
  options.step = 1e-5;
  ModalStepper stepper = mass_in_bore({ContactLaw::approach, 1e4, 1.0}, options);
  stepper.set_state(0, vector({0.0, 0.0}), vector({2.0, 1.0}));
  stepper.advance(0.5);
  EXPECT_GT(stepper.report().largest_penetration, 5e-3);
  EXPECT_LT(std::abs(stepper.energy().imbalance()), 1e-10 * stepper.energy().initial);
}

TEST(ModalStepping, TouchAndGoWithinOneFreeStepIsSeen) {
  // The crest reaches 1 % beyond the wall between two steps that both end before it.
  ModalSteppingOptions options;
  options.step = 2.0 * pi / 12.0;
  ModalStepper stepper({oscillators({1.0}, 0.0)}, {wall({ContactLaw::no_adhesion, 1e3, 0.0}, 0.99, {1.0})},
                       still, options);
  stepper.set_state(0, vector({std::cos(pi + 2.5 * pi / 12.0)}), vector({-std::sin(pi + 2.5 * pi / 12.0)}));
  stepper.advance(pi);
  ASSERT_GE(stepper.report().events, 2);
  // Touch at cos(t + phase) = 0.99, to the slack of the events.
  EXPECT_NEAR(stepper.events().front().time, pi - 2.5 * pi / 12.0 - std::acos(0.99), 1e-6);
}

TEST(ModalStepping, LandingOnOutputTimesChangesNothing) {
  const Wb1Modal wb1;
  ModalSteppingOptions options;
  options.tolerance = 1e-5;
  ModalStepper once = wb1.stepper(options);
  ModalStepper often = wb1.stepper(options);
  once.advance(0.1);
  for (int i = 1; i <= 1000; ++i) often.advance(i * 1e-4);
  EXPECT_EQ(often.time(), 0.1);
  EXPECT_NEAR(once.offset(0)[0], often.offset(0)[0], 1e-5 * once.report().largest_displacement);
}

TEST(ModalStepping, RefusesWhatCannotBeStepped) {
  const Wb1Modal wb1;
  using Faulty = std::function<void(ModalBody&, ContactPoint&, PrescribedMotion&, ModalSteppingOptions&)>;
  const Faulty faults[] = {[](auto& b, auto&, auto&, auto&) {
                             b.poles.pole[0] = {1.0, 10.0};
                           },
                           [](auto& b, auto&, auto&, auto&) {
                             b.poles.pole[0] = {NAN, 10.0};
                           },
                           [](auto& b, auto&, auto&, auto&) { b.poles.pole[0] = 0.0; },
                           [](auto& b, auto&, auto&, auto&) { b.poles.mode[0] = 3; },
                           [](auto& b, auto&, auto&, auto&) { b.poles.residue.resize(3); },
                           [](auto& b, auto&, auto&, auto&) { b.load = Eigen::MatrixX3d::Zero(3, 3); },
                           [](auto& b, auto&, auto&, auto&) { b.load(0, 0) = NAN; },
                           [](auto& b, auto&, auto&, auto&) { b.constant_load = Eigen::VectorXd::Zero(3); },
                           [](auto&, auto& p, auto&, auto&) { p.gap = -1.0; },
                           [](auto&, auto& p, auto&, auto&) { p.inside = Eigen::MatrixX2d::Zero(3, 2); },
                           [](auto&, auto&, auto& m, auto&) { m = nullptr; },
                           [](auto&, auto&, auto& m, auto&) {
                             m = [](double) { return MotionSample{0.0, NAN, 0.0}; };
                           },
                           [](auto&, auto&, auto&, auto& o) { o.tolerance = 0.0; },
                           [](auto&, auto&, auto&, auto& o) { o.tolerance = 1.0; },
                           [](auto&, auto&, auto&, auto& o) { o.step = -1e-5; },
                           [](auto&, auto&, auto&, auto& o) { o.step = NAN; },
                           [](auto&, auto&, auto&, auto& o) { o.longest_step = -1.0; },
                           [](auto&, auto&, auto&, auto& o) { o.highest_mode_hz = -1.0; },
                           [](auto&, auto&, auto&, auto& o) { o.displacement_scale = -1.0; },
                           [](auto&, auto&, auto&, auto& o) { o.contact_substeps = 0; }};
  for (const Faulty& fault : faults) {
    ModalBody body = wb1.body;
    ContactPoint stop = wb1.stop;
    PrescribedMotion motion = still;
    ModalSteppingOptions options;
    fault(body, stop, motion, options);
    EXPECT_THROW(ModalStepper({body}, {stop}, motion, options), Error);
  }
  ModalStepper stepper({wb1.body}, {wb1.stop}, still);
  EXPECT_THROW(ModalStepper({}, {}, still), Error);
  EXPECT_THROW(stepper.advance(-1.0), Error);
  EXPECT_THROW(stepper.advance(NAN), Error);
  EXPECT_THROW(stepper.displacement(1), Error);
  EXPECT_THROW(stepper.penetration(-1), Error);
  EXPECT_THROW(stepper.set_state(0, vector({1.0}), vector({1.0})), Error);
}

TEST(ModalStepping, StiffContactTendsToTheRigidOneAndTooStiffIsAnError) {
  Wb1Modal wb1;
  const auto at_rest = [&](double stiffness) {
    wb1.stop.law.stiffness = stiffness;
    ModalStepper stepper = wb1.stepper({});
    stepper.advance(0.05);
    EXPECT_LT(std::abs(stepper.energy().imbalance()), 1e-6 * stepper.energy().input);
    return stepper.offset(0)[0];
  };
  // Both are rigid against the wire: apart by no more than the tolerance (1e-3) of the largest
  // displacement, 2.4e-3 m.
  EXPECT_NEAR(at_rest(1e8), at_rest(1e11), 1e-3 * 2.4e-3);
  EXPECT_THROW(at_rest(1e17), Error);
}

TEST(ModalStepping, NotANumberInTheMotionIsAnErrorNotAResult) {
  const Wb1Modal wb1;
  const auto spoilt = [](double t) {
    MotionSample m = testing::wb1_motion(t);
    if (t > 0.01) m.acceleration = NAN;
    return m;
  };
  ModalStepper stepper({wb1.body}, {wb1.stop}, spoilt);
  EXPECT_THROW(stepper.advance(0.05), Error);
}

}  // namespace
}  // namespace struna::fem
