#include "fem/sampled_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/fem/filter_scene.hpp"

namespace struna::fem {
namespace {

using Eigen::VectorXd;
constexpr double two_pi = 2.0 * std::numbers::pi;

/// Amplitude at f [Hz] of the second half, which holds whole periods.
double amplitude(const VectorXd& x, double f, double interval) {
  std::complex<double> sum = 0.0;
  for (long n = x.size() / 2; n < x.size(); ++n)
    sum += x[n] * std::polar(1.0, -two_pi * f * interval * static_cast<double>(n));
  return 4.0 * std::abs(sum) / static_cast<double>(x.size());
}

/// A record of a motion, `count` samples at `rate` [Hz].
template <class Motion>
MotionHistory recorded(long count, double rate, const Motion& motion) {
  VectorXd samples(count);
  for (long n = 0; n < count; ++n) samples[n] = motion(static_cast<double>(n) / rate);
  return motion_from_samples(samples, 1.0 / rate);
}

bool is_warned(const SimulationReport& report, const std::string& text) {
  for (const auto& warning : report.warnings) {
    if (warning.find(text) != std::string::npos) return true;
  }
  return false;
}

TEST(SampledRun, ARecordOfAHigherRateIsNotFoldedIntoTheRecordsWritten) {
  // 700 Hz would appear at 300 Hz in records of 1 kHz.
  const auto motion = recorded(2001, 5000.0, [](double t) {
    return 1e-5 * std::sin(two_pi * 50.0 * t) + 1e-6 * std::sin(two_pi * 700.0 * t);
  });
  Scene scene = bare_scene(wire(), Excitation::Kind::record, 0.4);
  scene.simulation->sample_rate = 1000.0;
  scene.simulation->tolerance = 1e-2;
  for (const auto method : {IntegrationMethod::modal, IntegrationMethod::newmark}) {
    scene.simulation->method = method;
    const auto response = simulate(scene, motion);
    const VectorXd force = response.output.col(1);
    // The filter leaves 1e-4 of a force that at 700 Hz is a thousand times that at 50 Hz for an equal motion.
    EXPECT_LT(amplitude(response.motion, 300.0, 1e-3), 1e-4 * amplitude(response.motion, 50.0, 1e-3));
    EXPECT_LT(amplitude(force, 300.0, 1e-3), 0.02 * amplitude(force, 50.0, 1e-3));
    EXPECT_TRUE(is_warned(response.report, "the 2500 Hz that the motion reaches"));
  }
  // At the record's own rate nothing is filtered.
  scene.simulation->sample_rate = 5000.0;
  const auto same = simulate(scene, motion);
  EXPECT_NEAR(amplitude(same.motion, 700.0, 2e-4), 1e-6, 1e-12);
  EXPECT_EQ(same.report.oversampling, 1);
  EXPECT_FALSE(is_warned(same.report, "filter"));
}

TEST(SampledRun, ASineThatTheFilterWeakensIsWarnedOf) {
  Scene scene = banded_scene(Excitation::Kind::sine, 0.02, 1e-6);
  scene.simulation->excitation.frequency_hz = 1000.0;
  scene.simulation->sample_rate = 2100.0;
  scene.simulation->step = 1e-5;
  EXPECT_TRUE(is_warned(simulated(scene).report, "passes 840 Hz, less than the 1000 Hz"));
  scene.simulation->sample_rate = 2600.0;
  EXPECT_FALSE(is_warned(simulated(scene).report, "passes"));
}

TEST(SampledRun, ARecordOfNSamplesLastsNIntervals) {
  // Contact is looked at between the samples, and the last of those looks would lie behind the record's end.
  const auto motion = recorded(200, 5000.0, [](double t) { return 2e-4 * std::sin(two_pi * 50.0 * t); });
  Scene scene = banded_scene(Excitation::Kind::record, 200 / 5000.0, 5e-5);
  scene.simulation->sample_rate = 5000.0;
  const auto response = simulate(scene, motion);
  EXPECT_FALSE(response.report.linear);
  EXPECT_EQ(response.motion.size(), 200);
}

TEST(SampledRun, AGapThatIsNearlyReachedIsWatchedAndNeverTouched) {
  Scene scene = banded_scene(Excitation::Kind::sine, 0.1, 1.0);
  const double reach = simulated(scene).report.largest_offset;
  scene.contacts[0].gap = 1.015 * reach;  // nearer than what counts as clear, farther than what touches
  const auto response = simulated(scene);
  EXPECT_FALSE(response.report.linear);
  EXPECT_EQ(response.report.steps.events, 0);
  EXPECT_EQ(response.report.estimated_error, 0.0);
}

TEST(SampledRun, BothMethodsStartFromTheStaticShapeOfTheirBase) {
  // A random motion starts anywhere. The wire then penetrates its band, and neither method rests it there.
  Scene scene = banded_scene(Excitation::Kind::random, 0.002, 2e-5);
  scene.simulation->excitation.band_hi_hz = 100.0;
  scene.simulation->excitation.seed = 3;
  scene.simulation->step = 1e-6;
  double deepest[2];
  for (const auto method : {IntegrationMethod::modal, IntegrationMethod::newmark}) {
    scene.simulation->method = method;
    const auto response = simulated(scene);
    deepest[method == IntegrationMethod::modal ? 0 : 1] = response.report.steps.largest_penetration;
  }
  EXPECT_GT(deepest[0], 2e-5);
  // Newmark looks at the ends of steps of 1 us; the point moves at about 0.1 m/s.
  EXPECT_NEAR(deepest[1], deepest[0], 2e-7);
}

TEST(SampledRun, AStopDuringTheTrialsKeepsTheLinearPart) {
  Scene scene = banded_scene(Excitation::Kind::chirp, 0.2, 2e-3);
  scene.simulation->excitation.acceleration = 60.0;
  double latest = 0.0;
  // The first time that goes back is that of the trials.
  const auto response = simulate(scene, scene_motion(scene), [&](double t) {
    const bool on = t >= latest;
    latest = std::max(latest, t);
    return on;
  });
  EXPECT_FALSE(response.report.complete);
  EXPECT_GT(response.motion.size(), 10);
  EXPECT_LT(response.motion.size(), 2000);
}

TEST(SampledRun, NodesBesideTheTubeAreNotDrawnIntoIt) {
  // A hairpin whose second leg lies 0.1 m beside a tube around the first: its normal planes cut the tube too.
  Scene scene = banded_scene(Excitation::Kind::sine, 0.01, 5e-4);
  scene.bodies[0].centreline = spline_through(
      {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.25, 0.05, 0}, {0.2, 0.1, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}});
  scene.bodies[1].centreline = straight_line({0.05, 0, 0}, {0.15, 0, 0});
  scene.simulation->excitation.acceleration = 100.0;
  const SimulationPlan plan = plan_simulation(scene, 50.0);
  ASSERT_FALSE(plan.pairs.empty());
  for (const auto& joined : plan.pairs) EXPECT_LT(joined.pair.inside_arc_length, 0.2);
  SimulationReport report;
  report.warnings = plan.warnings;
  EXPECT_TRUE(is_warned(report, "lie beside 'band'"));
}

}  // namespace
}  // namespace struna::fem
