#include "ident/multi_mode.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/ident/simulated_modes.hpp"

namespace struna::ident {
namespace {

using simulated::function_of;
using simulated::lines;
using simulated::SimulatedMode;

std::vector<Mode> start_near(const std::vector<SimulatedMode>& modes) {
  std::vector<Mode> start;
  for (const auto& mode : modes) {
    Mode guess;
    guess.natural_frequency_hz = mode.pole.natural_frequency_hz * (1.0 + 0.2 * mode.pole.loss_factor);
    guess.loss_factor = 1.3 * mode.pole.loss_factor;
    start.push_back(guess);
  }
  return start;
}

TEST(MultiMode, FindsExactModesExactly) {
  for (const auto damping : {fem::Damping::structural, fem::Damping::viscous}) {
    const auto modes = simulated::eight_modes();
    const FrfKind kind = circle_form(FrfKind::receptance, damping);
    const auto tf = function_of(modes, lines(10.0, 1200.0, 0.5), kind, damping);
    MultiModeOptions options;
    options.damping = damping;
    const MultiModeFit fit = fit_multi_mode(tf, start_near(modes), options);
    EXPECT_TRUE(fit.converged);
    ASSERT_EQ(fit.modes.size(), modes.size());
    for (std::size_t r = 0; r < modes.size(); ++r) {
      // The solver's stopping tolerance.
      EXPECT_NEAR(fit.modes[r].natural_frequency_hz / modes[r].pole.natural_frequency_hz, 1.0, 1e-8);
      EXPECT_NEAR(fit.modes[r].loss_factor / modes[r].pole.loss_factor, 1.0, 1e-6);
      for (Eigen::Index k = 0; k < 3; ++k)
        EXPECT_NEAR(std::abs(fit.modes[r].modal_constant(k) - modes[r].constant[static_cast<std::size_t>(k)]),
                    0.0, 1e-5);
    }
  }
}

TEST(MultiMode, ResidualTermsStandForModesOutsideTheBand) {
  const auto all = simulated::eight_modes();
  auto tf = function_of(all, lines(90.0, 240.0, 0.25), FrfKind::receptance);
  const double sigma = 1e-3 * tf.outputs[0].value.cwiseAbs().maxCoeff();
  simulated::add_noise(tf, {sigma, sigma, sigma}, 1);
  const std::vector<SimulatedMode> inside = {all[2], all[3]};
  const MultiModeFit fit = fit_multi_mode(tf, start_near(inside));
  for (std::size_t r = 0; r < 2; ++r) {
    // Noise of a thousandth of the highest peak, and less than it of what 1/omega^2, 1, omega^2 leave of
    // modes an octave away.
    const Pole& truth = inside[r].pole;
    EXPECT_NEAR(fit.modes[r].natural_frequency_hz, truth.natural_frequency_hz, 2e-3 * bandwidth_hz(truth));
    EXPECT_NEAR(fit.modes[r].loss_factor / truth.loss_factor, 1.0, 5e-3);
  }
}

TEST(MultiMode, StandardErrorsAreTrue) {
  const auto modes = simulated::eight_modes();
  double score = 0.0;
  double misfit = 0.0;
  const int seeds = 10;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    auto tf = simulated::eight_mode_set(0.01, seed);
    tf = restrict_band(to_circle_form(tf, fem::Damping::structural), 5.0, 1200.0);
    const MultiModeFit fit = fit_multi_mode(tf, start_near(modes));
    misfit += fit.weighted_rms / seeds;
    for (std::size_t r = 0; r < modes.size(); ++r) {
      score += std::pow((fit.modes[r].natural_frequency_hz - modes[r].pole.natural_frequency_hz) /
                            fit.modes[r].natural_frequency_sigma,
                        2.0);
      score += std::pow(
          (fit.modes[r].loss_factor - modes[r].pole.loss_factor) / fit.modes[r].loss_factor_sigma, 2.0);
    }
  }
  // 160 squared scores: mean 1, three standard deviations 3 sqrt(2/160).
  EXPECT_NEAR(score / (2.0 * 8.0 * seeds), 1.0, 0.34);
  EXPECT_NEAR(misfit, 1.0, 0.01);  // 14000 lines a seed
}

TEST(MultiMode, DoesNotDependOnUnits) {
  const auto modes = simulated::eight_modes();
  auto tf = restrict_band(to_circle_form(simulated::eight_mode_set(0.01, 3), fem::Damping::structural), 5.0,
                          1200.0);
  const MultiModeFit one = fit_multi_mode(tf, start_near(modes));
  tf.outputs[1].value *= 1e6;
  tf.outputs[1].sigma *= 1e6;
  const MultiModeFit other = fit_multi_mode(tf, start_near(modes));
  for (std::size_t r = 0; r < modes.size(); ++r) {
    // The solver's stopping tolerance.
    EXPECT_NEAR(one.modes[r].natural_frequency_hz, other.modes[r].natural_frequency_hz,
                1e-3 * one.modes[r].natural_frequency_sigma);
    EXPECT_NEAR(one.modes[r].loss_factor, other.modes[r].loss_factor, 1e-3 * one.modes[r].loss_factor_sigma);
    EXPECT_NEAR(std::abs(other.modes[r].modal_constant(1) / one.modes[r].modal_constant(1)), 1e6, 1.0);
  }
}

}  // namespace
}  // namespace struna::ident
