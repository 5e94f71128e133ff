#include "apps/tradeoff_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "fem/error.hpp"
#include "ident/mode_identification.hpp"
#include "ident/resonance.hpp"

namespace struna::apps {
namespace {

using ident::ModeMethod;

/// Errors of one identification, relative, summed over modes as squares.
struct ModeErrors {
  double frequency = 0.0;
  double loss_factor = 0.0;
  long modes = 0;

  double frequency_rms() const { return std::sqrt(frequency / static_cast<double>(modes)); }
  double loss_factor_rms() const { return std::sqrt(loss_factor / static_cast<double>(modes)); }
};

void add_errors(const std::vector<ident::Mode>& truth, const std::vector<ident::Mode>& found,
                ModeErrors& errors) {
  for (const auto& mode : truth) {
    ++errors.modes;
    const ident::Mode* const nearest = nearest_mode(found, mode);
    if (nearest == nullptr) {
      errors.frequency += 1.0;
      errors.loss_factor += 1.0;
      continue;
    }
    errors.frequency += std::pow(nearest->natural_frequency_hz / mode.natural_frequency_hz - 1.0, 2);
    errors.loss_factor += std::pow(nearest->loss_factor / mode.loss_factor - 1.0, 2);
  }
}

/// Every `step`-th line.
ident::TransferFunction thinned(const ident::TransferFunction& tf, long step) {
  const long count = (tf.lines() + step - 1) / step;
  const Eigen::ArrayXi kept = Eigen::ArrayXi::LinSpaced(count, 0, static_cast<int>((count - 1) * step));
  ident::TransferFunction few = tf;
  few.frequency_hz = tf.frequency_hz(kept).eval();
  for (auto& output : few.outputs) {
    output.value = output.value(kept).eval();
    if (output.coherence.size() > 0) output.coherence = output.coherence(kept).eval();
    if (output.sigma.size() > 0) output.sigma = output.sigma(kept).eval();
  }
  return few;
}

/// Lines within the half-power band of the median mode: what a user can tell from a plot.
double lines_per_bandwidth(const ModesProblem& problem, const ident::TransferFunction& tf) {
  std::vector<double> width;
  for (const auto& mode : problem.truth) width.push_back(mode.loss_factor * mode.natural_frequency_hz);
  std::nth_element(width.begin(), width.begin() + static_cast<long>(width.size() / 2), width.end());
  const double spacing =
      (tf.frequency_hz(tf.lines() - 1) - tf.frequency_hz(0)) / static_cast<double>(tf.lines() - 1);
  return width[width.size() / 2] / spacing;
}

ident::Mode known_mode(const ident::Pole& pole) {
  ident::Mode mode;
  mode.natural_frequency_hz = pole.natural_frequency_hz;
  mode.loss_factor = pole.loss_factor;
  return mode;
}

struct KnownMode {
  ident::Pole pole;
  double shape[3];
};

/// The set of a published comparison of identification programs.
std::vector<KnownMode> eight_modes() {
  return {{{22, .050}, {1, .6, -.8}},
          {{61, .030}, {.9, -.7, .5}},
          {{118, .020}, {1.1, .9, .7}},
          {{205, .0125}, {.8, -1.1, .95}},
          {{340, .0075}, {1.05, .5, -1.15}},
          {{600, .008}, {.95, -.8, .6}},
          {{(600 + 1.5 * 4.8) / (1 - 1.5 * .01), .010}, {1, .9, -.75}},
          {{970, .005}, {.85, 1, -.9}}};
}

ident::TransferFunction function_of(const std::vector<KnownMode>& modes) {
  ident::TransferFunction tf;
  tf.frequency_hz = Eigen::VectorXd::LinSpaced(4801, 0.0, 1200.0);
  for (int k = 0; k < 3; ++k) {
    ident::TransferFunction::Output output;
    output.name = fmt::format("acceleration_{}", k + 1);
    output.kind = ident::FrfKind::accelerance;
    output.unit = ident::unit_of(output.kind);
    output.value = Eigen::VectorXcd::Zero(tf.lines());
    for (long i = 0; i < tf.lines(); ++i) {
      const double omega = 2.0 * std::numbers::pi * tf.frequency_hz(i);
      for (const auto& mode : modes) {
        output.value(i) +=
            -omega * omega *
            ident::modal_share(mode.shape[k] * mode.shape[0], mode.pole, omega, fem::Damping::structural);
      }
    }
    tf.outputs.push_back(std::move(output));
  }
  return tf;
}

void add_noise(ident::TransferFunction& tf, double level, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (auto& output : tf.outputs) {
    const double rms = std::sqrt(output.value.squaredNorm() / static_cast<double>(tf.lines()));
    const double sigma = level * rms / std::numbers::sqrt2;
    for (auto& value : output.value) {
      const double re = normal(engine), im = normal(engine);
      value += sigma * std::complex<double>(re, im);
    }
    output.sigma = Eigen::VectorXd::Constant(tf.lines(), sigma);
  }
}

TradeoffChart chart_of(const ModesProblem& problem, const std::string& quantity, double reference_error) {
  TradeoffChart chart;
  chart.stage = "modes";
  chart.problem = problem.name;
  chart.quantity = quantity;
  chart.error_label = "rms over the modes of the relative error; a mode not found counts as 100 %";
  chart.reference = problem.reference;
  chart.reference_error = reference_error;
  return chart;
}

}  // namespace

const ident::Mode* nearest_mode(const std::vector<ident::Mode>& found, const ident::Mode& truth) {
  const ident::Mode* nearest = nullptr;
  double reach = truth.loss_factor * truth.natural_frequency_hz;
  for (const auto& mode : found) {
    const double distance = std::abs(mode.natural_frequency_hz - truth.natural_frequency_hz);
    if (distance > reach) continue;
    reach = distance;
    nearest = &mode;
  }
  return nearest;
}

ModesProblem eight_modes_problem(double noise, int draws) {
  ModesProblem problem;
  problem.name = fmt::format("eight modes at {:g} % noise", 100.0 * noise);
  problem.reference = "the modes put in (exact)";
  const auto modes = eight_modes();
  for (const auto& mode : modes) problem.truth.push_back(known_mode(mode.pole));
  const ident::TransferFunction exact = function_of(modes);
  for (int draw = 0; draw < draws; ++draw) {
    problem.draws.push_back(exact);
    add_noise(problem.draws.back(), noise, static_cast<unsigned>(draw + 1));
  }
  return problem;
}

ModesProblem measured_modes_problem(const ident::TransferFunction& tf, const std::string& name) {
  ModesProblem problem;
  problem.name = name;
  problem.draws = {tf};
  const auto found = ident::identify_modes(tf).modes;
  for (const auto& mode : found) {
    const bool sound = mode.flags.empty() && mode.loss_factor_sigma > 0.0;
    if (!sound) continue;
    problem.truth.push_back(mode);
    problem.frequency_reference_error +=
        std::pow(mode.natural_frequency_sigma / mode.natural_frequency_hz, 2);
    problem.loss_factor_reference_error += std::pow(mode.loss_factor_sigma / mode.loss_factor, 2);
  }
  if (problem.truth.empty()) {
    throw Error(
        fmt::format("tradeoff: {}: no mode without a flag ({} in all) that others could be compared "
                    "with; a finer resolution or a longer record is needed",
                    name, found.size()));
  }
  const auto count = static_cast<double>(problem.truth.size());
  problem.frequency_reference_error = std::sqrt(problem.frequency_reference_error / count);
  problem.loss_factor_reference_error = std::sqrt(problem.loss_factor_reference_error / count);
  problem.reference = fmt::format(
      "the {} modes without flags that the default method finds on all lines; their standard errors are "
      "the reference's",
      problem.truth.size());
  return problem;
}

std::vector<TradeoffChart> tradeoff_modes(const ModesProblem& problem, const TradeoffRun& run) {
  TradeoffChart frequency = chart_of(problem, "natural frequency", problem.frequency_reference_error);
  TradeoffChart loss_factor = chart_of(problem, "loss factor", problem.loss_factor_reference_error);
  frequency.target = 1e-4;
  for (const ModeMethod method :
       {ModeMethod::automatic, ModeMethod::multi, ModeMethod::circle, ModeMethod::half_power}) {
    for (const long step : {16L, 8L, 4L, 2L, 1L}) {
      ident::ModeOptions options;
      options.damping = problem.damping;
      options.method = method;
      run.progress(fmt::format("modes: {}, {}, every {}. line", problem.name, to_string(method), step));
      ModeErrors errors;
      double seconds = 0.0;
      std::vector<ident::TransferFunction> few;
      for (const auto& draw : problem.draws) few.push_back(thinned(draw, step));
      if (few.front().lines() < 40) continue;
      for (std::size_t d = 0; d < few.size(); ++d) {
        ident::ModeSet set;
        const auto identify = [&] { set = ident::identify_modes(few[d], options); };
        if (d == 0)
          seconds = best_seconds(run.timing, identify);
        else
          identify();
        add_errors(problem.truth, set.modes, errors);
      }
      const bool usual = method == ident::ModeOptions{}.method && step == 1;
      const double lines = lines_per_bandwidth(problem, few.front());
      const TradeoffRow row{to_string(method), "lines per bandwidth [-]", lines, 0.0, seconds, usual, false};
      frequency.rows.push_back(row);
      frequency.rows.back().error = errors.frequency_rms();
      loss_factor.rows.push_back(row);
      loss_factor.rows.back().error = errors.loss_factor_rms();
    }
  }
  mark_pareto(frequency);
  mark_pareto(loss_factor);
  return {loss_factor, frequency};
}

std::vector<TradeoffChart> tradeoff_modes(const TradeoffRun& run) {
  std::vector<TradeoffChart> charts;
  for (const double noise : {0.001, 0.01, 0.05}) {
    for (auto& chart : tradeoff_modes(eight_modes_problem(noise, 8), run)) charts.push_back(std::move(chart));
  }
  return charts;
}

}  // namespace struna::apps
