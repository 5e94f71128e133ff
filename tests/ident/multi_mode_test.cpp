#include "ident/multi_mode.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "ident/pole_fit.hpp"
#include "simulated_modes.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
using fem::Damping;
using simulated::add_noise;
using simulated::function_of;
using simulated::lines;
using simulated::SimulatedMode;

Mode start_at(double f, double eta) {
  Mode mode;
  mode.natural_frequency_hz = f;
  mode.loss_factor = eta;
  return mode;
}

// Three modes in two outputs, constants such that peaks are near 1, complex for one.
std::vector<SimulatedMode> three_modes(Damping damping) {
  std::vector<SimulatedMode> modes = {
      {{40.0, 0.02}, {1.0, 0.5}}, {{43.0, 0.03}, {-0.7, Complex(0.6, 0.3)}}, {{90.0, 0.01}, {0.4, -1.2}}};
  for (SimulatedMode& mode : modes)
    for (Complex& constant : mode.constant) constant *= pole_scale(mode.pole, damping);
  return modes;
}
const std::vector<Mode> rough_start = {start_at(39.6, 0.03), start_at(43.5, 0.02), start_at(90.3, 0.014)};

TEST(MultiMode, NoiseFreeModesAreExactInEitherDamping) {
  for (const Damping damping : {Damping::structural, Damping::viscous}) {
    const auto truth = three_modes(damping);
    const FrfKind form = damping == Damping::structural ? FrfKind::receptance : FrfKind::mobility;
    const TransferFunction tf = function_of(truth, lines(20.0, 120.0, 0.1), form, damping);
    MultiModeOptions options;
    options.damping = damping;
    const MultiModeFit fit = fit_multi_mode(tf, rough_start, options);
    ASSERT_EQ(fit.modes.size(), 3u);
    EXPECT_TRUE(fit.converged);
    for (std::size_t r = 0; r < 3; ++r) {
      // Convergence stops where the fit is far below the noise floor that is assumed without sigma.
      EXPECT_NEAR(fit.modes[r].natural_frequency_hz, truth[r].pole.natural_frequency_hz, 1e-7);
      EXPECT_NEAR(fit.modes[r].loss_factor, truth[r].pole.loss_factor, 1e-8);
      for (long k = 0; k < 2; ++k)
        EXPECT_NEAR(std::abs(fit.modes[r].modal_constant(k) / truth[r].constant[std::size_t(k)] - 1.0), 0.0,
                    1e-6);
    }
    EXPECT_LT((fit.fitted.col(0) - tf.outputs[0].value).norm(), 1e-7 * tf.outputs[0].value.norm());
  }
}

TEST(MultiMode, ViscousAndHystereticPolesAreNotTheSame) {
  // A viscous mode read as hysteretic through the receptance is eta^2/4 or so off in frequency, not in the
  // first order.
  const Pole pole{100.0, 0.06};
  const TransferFunction mobility =
      function_of({{{pole}, {1.0}}}, lines(80.0, 125.0, 0.1), FrfKind::mobility, Damping::viscous);
  const TransferFunction receptance = to_circle_form(mobility, Damping::structural);
  const MultiModeFit fit = fit_multi_mode(receptance, {start_at(100.0, 0.05)});
  const double shift = fit.modes[0].natural_frequency_hz / 100.0 - 1.0;
  EXPECT_GT(std::abs(shift), 1e-5);
  EXPECT_LT(std::abs(shift), 0.06 * 0.06);
}

TEST(MultiMode, ResidualTermsTakeUpWhatLiesOutsideTheBand) {
  std::vector<SimulatedMode> modes = three_modes(Damping::structural);
  const Pole low{6.0, 0.02}, high{400.0, 0.02};
  modes.push_back(
      {low, {20.0 * pole_scale(low, Damping::structural), 5.0 * pole_scale(low, Damping::structural)}});
  modes.push_back(
      {high, {3.0 * pole_scale(high, Damping::structural), -8.0 * pole_scale(high, Damping::structural)}});
  const TransferFunction tf = function_of(modes, lines(30.0, 110.0, 0.1), FrfKind::apparent_mass,
                                          Damping::structural, {Complex(2.0, 0.1), Complex(-3.0, 0.0)});
  const MultiModeFit fit = fit_multi_mode(tf, rough_start);
  for (std::size_t r = 0; r < 3; ++r) {
    // Truncation of the outer modes after three terms: (30/6)^-4 and (110/400)^4 of their tails.
    EXPECT_NEAR(fit.modes[r].natural_frequency_hz, modes[r].pole.natural_frequency_hz,
                2e-3 * bandwidth_hz(modes[r].pole));
    EXPECT_NEAR(fit.modes[r].loss_factor / modes[r].pole.loss_factor, 1.0, 4e-3);
  }
}

TEST(MultiMode, StandardErrorsTellTheScatter) {
  for (const Damping damping : {Damping::structural, Damping::viscous}) {
    const auto truth = three_modes(damping);
    const FrfKind form = damping == Damping::structural ? FrfKind::receptance : FrfKind::mobility;
    const TransferFunction clean = function_of(truth, lines(20.0, 120.0, 0.1), form, damping);
    MultiModeOptions options;
    options.damping = damping;
    double f_pull = 0.0, eta_pull = 0.0, constant_pull = 0.0;
    const int seeds = 60;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      TransferFunction tf = clean;
      add_noise(tf, {0.02, 0.05}, seed);
      const MultiModeFit fit = fit_multi_mode(tf, rough_start, options);
      EXPECT_NEAR(fit.weighted_rms, 1.0, 0.07);  // 4000 data: 1.1 % standard deviation
      for (std::size_t r = 0; r < 3; ++r) {
        const Mode& mode = fit.modes[r];
        f_pull += std::pow(
            (mode.natural_frequency_hz - truth[r].pole.natural_frequency_hz) / mode.natural_frequency_sigma,
            2.0);
        eta_pull += std::pow((mode.loss_factor - truth[r].pole.loss_factor) / mode.loss_factor_sigma, 2.0);
        for (long k = 0; k < 2; ++k)
          constant_pull += std::norm((mode.modal_constant(k) - truth[r].constant[std::size_t(k)]) /
                                     mode.modal_constant_sigma(k)) /
                           4.0;
      }
    }
    // Mean squares of 180 pulls scatter by 10 %.
    EXPECT_NEAR(f_pull / (3.0 * seeds), 1.0, 0.3);
    EXPECT_NEAR(eta_pull / (3.0 * seeds), 1.0, 0.3);
    EXPECT_NEAR(constant_pull / (3.0 * seeds), 1.0, 0.3);
  }
}

TEST(MultiMode, WithoutSigmaTheScatterGivesTheStandardErrors) {
  TransferFunction tf =
      function_of(three_modes(Damping::structural), lines(20.0, 120.0, 0.1), FrfKind::receptance);
  add_noise(tf, {0.02, 0.05}, 4);
  const MultiModeFit known = fit_multi_mode(tf, rough_start);
  for (auto& output : tf.outputs) output.sigma.resize(0);
  const MultiModeFit estimated = fit_multi_mode(tf, rough_start);
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_NEAR(estimated.modes[r].natural_frequency_sigma / known.modes[r].natural_frequency_sigma, 1.0,
                0.2);
    EXPECT_NEAR(estimated.modes[r].natural_frequency_hz, known.modes[r].natural_frequency_hz,
                2.0 * known.modes[r].natural_frequency_sigma);
  }
}

TEST(MultiMode, ScalingAndOrderOfOutputsChangeNothingButTheConstants) {
  TransferFunction tf =
      function_of(three_modes(Damping::structural), lines(20.0, 120.0, 0.1), FrfKind::receptance);
  add_noise(tf, {0.02, 0.05}, 4);
  const MultiModeFit before = fit_multi_mode(tf, rough_start);
  std::swap(tf.outputs[0], tf.outputs[1]);
  tf.outputs[0].value *= 1e6;
  tf.outputs[0].sigma *= 1e6;
  const MultiModeFit after = fit_multi_mode(tf, rough_start);
  for (std::size_t r = 0; r < 3; ++r) {
    // Rounding along another path to the same minimum.
    EXPECT_NEAR(after.modes[r].natural_frequency_hz, before.modes[r].natural_frequency_hz,
                2e-3 * before.modes[r].natural_frequency_sigma);
    EXPECT_NEAR(after.modes[r].loss_factor, before.modes[r].loss_factor,
                2e-3 * before.modes[r].loss_factor_sigma);
    EXPECT_NEAR(std::abs(after.modes[r].modal_constant(0) / before.modes[r].modal_constant(1)), 1e6, 1e2);
  }
}

TEST(MultiMode, StretchingTheFrequencyAxisStretchesThePoles) {
  // The same lines and values, all frequencies ten times: only units change.
  TransferFunction tf =
      function_of(three_modes(Damping::structural), lines(20.0, 120.0, 0.1), FrfKind::receptance);
  const MultiModeFit before = fit_multi_mode(tf, rough_start);
  tf.frequency_hz *= 10.0;
  std::vector<Mode> start = rough_start;
  for (Mode& mode : start) mode.natural_frequency_hz *= 10.0;
  const MultiModeFit after = fit_multi_mode(tf, start);
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_NEAR(after.modes[r].natural_frequency_hz, 10.0 * before.modes[r].natural_frequency_hz, 1e-6);
    EXPECT_NEAR(after.modes[r].loss_factor, before.modes[r].loss_factor, 1e-8);
  }
}

TEST(MultiMode, UnequalWeightsAreUsed) {
  // One output is drowned: alone the other gives the same poles.
  TransferFunction tf =
      function_of(three_modes(Damping::structural), lines(20.0, 120.0, 0.1), FrfKind::receptance);
  add_noise(tf, {0.01, 3.0}, 8);
  tf.outputs[1].sigma.array() *= tf.frequency_hz.array();  // not proportional to the other's
  tf.outputs[1].sigma /= 20.0;
  const MultiModeFit both = fit_multi_mode(tf, rough_start);
  tf.outputs.pop_back();
  const MultiModeFit good = fit_multi_mode(tf, rough_start);
  for (std::size_t r = 0; r < 3; ++r)
    EXPECT_NEAR(both.modes[r].loss_factor, good.modes[r].loss_factor, 0.1 * good.modes[r].loss_factor_sigma);
}

TEST(MultiMode, ModesComeOutAscendingWhateverTheStart) {
  const TransferFunction tf =
      function_of(three_modes(Damping::structural), lines(20.0, 120.0, 0.1), FrfKind::receptance);
  const MultiModeFit fit = fit_multi_mode(tf, {rough_start[2], rough_start[0], rough_start[1]});
  EXPECT_NEAR(fit.modes[0].natural_frequency_hz, 40.0, 1e-6);
  EXPECT_NEAR(fit.modes[2].natural_frequency_hz, 90.0, 1e-6);
}

TEST(PoleFit, RefusesWhatItCannotFit) {
  TransferFunction tf =
      function_of(three_modes(Damping::structural), lines(39.0, 41.0, 1.0), FrfKind::receptance);
  add_noise(tf, {0.01, 0.01}, 1);
  const PoleFitOptions options;
  EXPECT_THROW(fit_poles(tf, {{40.0, 0.02}}, options), Error);  // 12 data, 18 parameters
  EXPECT_THROW(fit_poles(tf, {{-40.0, 0.02}}, options), Error);
  EXPECT_THROW(fit_poles(tf, {{40.0, 0.0}}, options), Error);
  tf.outputs[0].sigma.resize(0);
  EXPECT_THROW(fit_poles(tf, {}, options), Error);
}

TEST(PoleFit, CorrelatedLinesWidenTheStandardErrors) {
  TransferFunction tf =
      function_of(three_modes(Damping::structural), lines(20.0, 120.0, 0.1), FrfKind::receptance);
  add_noise(tf, {0.02, 0.02}, 2);
  PoleFitOptions options;
  std::vector<Pole> start;
  for (const Mode& mode : rough_start) start.push_back({mode.natural_frequency_hz, mode.loss_factor});
  EXPECT_NEAR(fit_poles(tf, start, options).line_correlation, 1.0, 0.15);
  const TransferFunction clean =
      function_of(three_modes(Damping::structural), tf.frequency_hz, FrfKind::receptance);
  for (std::size_t k = 0; k < 2; ++k) {  // noise summed over two lines: correlation one half at lag one
    const Eigen::VectorXcd noise = tf.outputs[k].value - clean.outputs[k].value;
    for (long i = 1; i < tf.lines(); ++i)
      tf.outputs[k].value(i) = clean.outputs[k].value(i) + (noise(i) + noise(i - 1)) / std::numbers::sqrt2;
  }
  EXPECT_NEAR(fit_poles(tf, start, options).line_correlation, 2.0, 0.25);
}

}  // namespace
}  // namespace struna::ident
