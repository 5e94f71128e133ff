#include "apps/limit_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "ident/mode_identification.hpp"
#include "ident/resonance.hpp"

namespace struna::apps {
namespace {

using ident::Mode;
using ident::ModeMethod;
using ident::Pole;

constexpr double frequency_hz = 200.0;
constexpr double loss_factor = 0.02;
constexpr double bandwidth_hz = frequency_hz * loss_factor;
/// Stated in docs/limits.md: of the half-power bandwidth, and of the loss factor.
constexpr double frequency_tolerance = 0.01;
constexpr double loss_factor_tolerance = 0.01;

struct Share {
  Pole pole;
  double constant[2];
};

std::vector<Share> shares(double spacing) {
  const double second = frequency_hz + spacing * bandwidth_hz;
  return {{{frequency_hz, loss_factor}, {1.0, 0.6}},
          {{second, loss_factor}, {0.9, -0.7}},
          {{90.0, 0.03}, {0.7, 0.5}},
          {{450.0, 0.015}, {1.1, -0.8}}};
}

/// In circle form; every mode's circle has a diameter of about 1. `noise` of that, in real and imaginary
/// part.
ident::TransferFunction function_of(const std::vector<Share>& modes, double step_hz, double noise,
                                    unsigned seed) {
  ident::TransferFunction tf;
  const double lo = 130.0, hi = 310.0;
  tf.frequency_hz = Eigen::VectorXd::LinSpaced(std::lround((hi - lo) / step_hz) + 1, lo, hi);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 2; ++k) {
    ident::TransferFunction::Output output;
    output.name = fmt::format("motion_{}", k + 1);
    output.kind = ident::FrfKind::receptance;
    output.unit = ident::unit_of(output.kind);
    output.value = Eigen::VectorXcd::Zero(tf.lines());
    for (long i = 0; i < tf.lines(); ++i) {
      const double omega = 2.0 * std::numbers::pi * tf.frequency_hz(i);
      for (const auto& mode : modes) {
        output.value(i) += mode.constant[k] * ident::pole_scale(mode.pole, fem::Damping::structural) *
                           ident::pole_function(mode.pole, omega, fem::Damping::structural);
      }
      const double re = normal(engine), im = normal(engine);
      output.value(i) += noise * std::complex<double>(re, im);
    }
    output.sigma = Eigen::VectorXd::Constant(tf.lines(), noise);
    tf.outputs.push_back(std::move(output));
  }
  return tf;
}

void add_word(ident::ModeFlag flag, std::string& words) {
  words += (words.empty() ? "" : ";") + to_string(flag);
}

LimitMap mode_limits(const LimitRun& run, ModeMethod method, int usual_seeds, LimitMap map) {
  map.quantity = "natural frequency over the bandwidth or loss factor (relative): the worse of the two";
  map.axes = {run.axis("spacing [bandwidths]", {0.05, 0.1, 0.2, 0.3, 0.4, 0.7, 1, 1.5, 2, 3, 5, 8, 15}),
              run.axis("noise [% of diameter]", {0.03, 0.1, 0.3, 1, 3, 10}),
              run.axis("lines per bandwidth", {5, 8, 16, 32})};
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    const std::vector<Share> truth = shares(at[0]);
    for (const unsigned seed : run.draws(usual_seeds)) {
      const auto tf = function_of(truth, bandwidth_hz / at[2], 0.01 * at[1], seed);
      ident::ModeOptions options;
      options.method = method;
      options.band_lo_hz = tf.frequency_hz(0);
      options.band_hi_hz = tf.frequency_hz(tf.lines() - 1);
      const ident::ModeSet set = ident::identify_modes(tf, options);
      for (int r = 0; r < 2; ++r) {
        LimitTrial trial;
        trial.at = at;
        trial.seed = seed;
        const Pole& pole = truth[static_cast<std::size_t>(r)].pole;
        const Mode* const mode = mode_near(set.modes, pole);
        trial.refused = mode == nullptr;
        if (mode != nullptr) {
          judge_mode(*mode, pole, trial);
          if (mode->has(ident::ModeFlag::may_be_two)) add_word(ident::ModeFlag::may_be_two, trial.flags);
        }
        map.trials.push_back(std::move(trial));
      }
    }
  });
  return map;
}

}  // namespace

const Mode* mode_near(const std::vector<Mode>& found, const Pole& truth) {
  const auto distance = [&](const Mode& mode) {
    return std::abs(mode.natural_frequency_hz - truth.natural_frequency_hz);
  };
  const auto best = std::min_element(found.begin(), found.end(),
                                     [&](const Mode& a, const Mode& b) { return distance(a) < distance(b); });
  return best == found.end() || distance(*best) > ident::bandwidth_hz(truth) ? nullptr : &*best;
}

void judge_mode(const Mode& mode, const Pole& truth, LimitTrial& trial) {
  const double bandwidth = ident::bandwidth_hz(truth);
  const double frequency_error = std::abs(mode.natural_frequency_hz - truth.natural_frequency_hz) / bandwidth;
  const double frequency_sigma = mode.natural_frequency_sigma / bandwidth;
  const double loss_error = std::abs(mode.loss_factor / truth.loss_factor - 1.0);
  const double loss_sigma = mode.loss_factor_sigma / truth.loss_factor;
  const LimitTrial frequency{{}, 0, frequency_error, frequency_sigma, frequency_tolerance, false, ""};
  const LimitTrial damping{{}, 0, loss_error, loss_sigma, loss_factor_tolerance, false, ""};
  const bool by_frequency = outcome(frequency) != outcome(damping)
                                ? outcome(frequency) > outcome(damping)
                                : frequency_error * loss_sigma > loss_error * frequency_sigma;
  const LimitTrial& worse = by_frequency ? frequency : damping;
  trial.error = worse.error;
  trial.sigma = worse.sigma;
  trial.tolerance = worse.tolerance;
  for (const auto flag : mode.flags)
    if (flag != ident::ModeFlag::may_be_two) add_word(flag, trial.flags);
}

LimitMap circle_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "circle";
  map.title = "Circle fit: two modes side by side";
  map.fails = "a neighbour's tail bends the arc, and the loss factor is off by far more than noise tells";
  map.sign = "the fit of all poles together: how far it parts from the circle, and what it leaves";
  map.then =
      "states that distance in the standard error, flags the mode double_mode, close_modes, poor_circle or "
      "may_be_two, or refuses it";
  return mode_limits(run, ModeMethod::circle, 12, std::move(map));
}

LimitMap multi_mode_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "modes";
  map.title = "Automatic multi-mode fit: two modes side by side";
  map.fails = "two modes within a fraction of a bandwidth become one pole, or two that noise places";
  map.sign = "rank and shape of what the pole leaves, and by the distance that noise would hide";
  map.then = "flags the mode double_mode, may_be_two, close_modes or noisy";
  return mode_limits(run, ModeMethod::automatic, 6, std::move(map));
}

}  // namespace struna::apps
