#include "apps/tradeoff_transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/shaken_wire.hpp"
#include "apps/tradeoff_modes.hpp"
#include "fem/error.hpp"
#include "ident/mode_identification.hpp"

namespace struna::apps {
namespace {

constexpr Band shaken_band{10.0, 700.0};
constexpr double displacement_noise = 3e-4;  ///< of the rms

/// One way to estimate; a further one is one more entry in methods().
struct TransferMethod {
  std::string name;
  TransferSettings settings;  ///< resolution left open
};

TransferMethod welch(const std::string& name, ident::Window window, ident::Estimator ratio, double overlap) {
  TransferSettings settings;
  settings.method = ident::EstimateMethod::welch;
  settings.estimator = ratio;
  settings.welch.window = window;
  settings.welch.overlap = overlap;
  return {name, settings};
}

TransferMethod local(const std::string& name, ident::EstimateMethod method) {
  TransferSettings settings;
  settings.method = method;
  return {name, settings};
}

std::vector<TransferMethod> methods() {
  using ident::Estimator;
  using ident::Window;
  const double overlap = ident::WelchOptions{}.overlap;
  return {local("local rational", ident::EstimateMethod::local_rational),
          local("local polynomial", ident::EstimateMethod::local_polynomial),
          welch("h1; Hann", Window::hann, Estimator::h1, overlap),
          welch("h2; Hann", Window::hann, Estimator::h2, overlap),
          welch("hv; Hann", Window::hann, Estimator::hv, overlap),
          welch("h1; Hann; no overlap", Window::hann, Estimator::h1, 0.0),
          welch("h1; rectangular", Window::rectangular, Estimator::h1, 0.0)};
}

/// The entry of methods() that an estimate was made by; one that is not there goes by the library's name.
std::string name_of(const ident::TransferEstimate& estimate) {
  for (const auto& method : methods()) {
    const bool same_ratio =
        estimate.method != ident::EstimateMethod::welch ||
        (method.settings.estimator == estimate.ratio && method.settings.welch.window == estimate.window &&
         method.settings.welch.overlap == ident::WelchOptions{}.overlap);
    if (method.settings.method == estimate.method && same_ratio) return method.name;
  }
  return ident::to_string(estimate.method);
}

/// rms over draws and modes of eta/eta_true - 1; a mode that is not found counts as 1.
double loss_factor_error(const TransferProblem& problem,
                         const std::vector<ident::TransferEstimate>& estimated) {
  ident::ModeOptions options;
  options.damping = problem.damping;
  for (const auto& mode : problem.truth) options.frequencies_hz.push_back(mode.natural_frequency_hz);
  double sum = 0.0;
  long count = 0;
  for (const auto& estimate : estimated) {
    const auto found = ident::identify_modes(estimate.function, options).modes;
    for (const auto& truth : problem.truth) {
      const ident::Mode* const mode = nearest_mode(found, truth);
      const double error = mode == nullptr ? 1.0 : mode->loss_factor / truth.loss_factor - 1.0;
      sum += error * error;
      ++count;
    }
  }
  return std::sqrt(sum / static_cast<double>(count));
}

/// Every draw's function; `seconds` of the first.
std::vector<ident::TransferEstimate> estimate_all(const TransferProblem& problem,
                                                  const TransferSettings& settings, const Timing& timing,
                                                  double& seconds) {
  std::vector<ident::TransferEstimate> all(static_cast<std::size_t>(problem.draws));
  seconds = best_seconds(timing, [&] { all[0] = problem.estimate(0, settings); });
  for (long draw = 1; draw < problem.draws; ++draw)
    all[static_cast<std::size_t>(draw)] = problem.estimate(draw, settings);
  return all;
}

TradeoffChart chart_of(const TransferProblem& problem, const std::string& name) {
  TradeoffChart chart;
  chart.stage = "transfer";
  chart.problem = name;
  chart.quantity = "loss factor";
  chart.error_label = fmt::format(
      "rms over {} modes{} of the relative error; a mode not found counts as 100 %", problem.truth.size(),
      problem.draws > 1 ? fmt::format(" and {} records", problem.draws) : "");
  chart.reference = problem.reference;
  chart.reference_error = problem.reference_error;
  return chart;
}

/// A row for one method at one resolution; none where the method cannot follow it.
void add_row(const TransferProblem& problem, const TransferMethod& method, double resolution_hz,
             const TradeoffRun& run, TradeoffChart& chart) {
  TransferSettings settings = method.settings;
  settings.welch.resolution_hz = resolution_hz;
  TradeoffRow row{method.name, "resolution [Hz]"};
  try {
    const auto estimated = estimate_all(problem, settings, run.timing, row.seconds);
    row.value = estimated.front().resolution_hz;
    row.error = loss_factor_error(problem, estimated);
    chart.rows.push_back(row);
  } catch (const Error& error) {
    const std::string note =
        fmt::format("Without {} at {:.3g} Hz: {}.", method.name, resolution_hz, error.what());
    chart.notes.push_back(note);
  }
}

/// What the program does when nothing is said.
void add_default_row(const TransferProblem& problem, const TradeoffRun& run, TradeoffChart& chart) {
  TradeoffRow row{"", "resolution [Hz]"};
  const auto estimated = estimate_all(problem, TransferSettings{}, run.timing, row.seconds);
  row.method = name_of(estimated.front());
  row.value = estimated.front().resolution_hz;
  row.error = loss_factor_error(problem, estimated);
  row.is_default = true;
  std::erase_if(chart.rows, [&](const TradeoffRow& other) {  // the same, asked for in words
    return other.method == row.method && std::abs(other.value - row.value) < 1e-6 * row.value;
  });
  chart.rows.push_back(row);
}

/// Rows of a method next to each other, by knob: a line of the chart.
void sort_rows(TradeoffChart& chart) {
  std::vector<std::string> order;
  for (const auto& row : chart.rows) {
    if (std::count(order.begin(), order.end(), row.method) == 0) order.push_back(row.method);
  }
  const auto place = [&](const TradeoffRow& row) {
    return std::find(order.begin(), order.end(), row.method) - order.begin();
  };
  std::stable_sort(chart.rows.begin(), chart.rows.end(), [&](const auto& a, const auto& b) {
    return place(a) != place(b) ? place(a) < place(b) : a.value < b.value;
  });
}

}  // namespace

TransferProblem shaken_wire_problem(double duration, double noise, long draws) {
  TransferProblem problem;
  problem.name = fmt::format("shaken wire at {:g} % noise; {:g} s", 100.0 * noise, duration);
  problem.duration = duration;
  problem.draws = draws;
  problem.reference = "the closed form's natural frequencies and loss factor (exact)";
  const ShakenWire wire;
  for (const double f : wire.natural_frequencies_hz(shaken_band.hi_hz)) {
    problem.truth.emplace_back();
    problem.truth.back().natural_frequency_hz = f;
    problem.truth.back().loss_factor = wire.loss_factor;
  }
  const auto records = std::make_shared<std::vector<ident::Record>>();
  for (long draw = 0; draw < draws; ++draw) {
    records->push_back(wire.record(duration, shaken_band.lo_hz, shaken_band.hi_hz,
                                   {displacement_noise, noise}, static_cast<unsigned>(draw + 1)));
  }
  problem.estimate = [records](long draw, const TransferSettings& settings) {
    const ident::Record& record = (*records)[static_cast<std::size_t>(draw)];
    ident::TransferEstimate estimate = ident::estimate_transfer(
        record, "displacement", {"force_y"}, {settings.method, settings.estimator, settings.welch, {}});
    estimate.function = ident::restrict_band(estimate.function, shaken_band.lo_hz, shaken_band.hi_hz);
    return estimate;
  };
  return problem;
}

TransferProblem study_transfer_problem(const Study& study, const std::string& name) {
  TransferProblem problem;
  problem.name = name;
  problem.damping = study.modes.damping;
  for (const auto& file : study.records) {
    const ident::Record record = ident::read_record(file, {study.input});
    problem.duration += static_cast<double>(record.samples.rows()) * record.sample_interval;
  }
  problem.estimate = [study](long, const TransferSettings& settings) {
    ident::TransferEstimate estimate = ident::estimate_transfer(
        study.records, study.input, study.outputs, {settings.method, settings.estimator, settings.welch, {}},
        study.corrections);
    const auto& band = study.transfer.band;
    if (band) estimate.function = ident::restrict_band(estimate.function, band->lo_hz, band->hi_hz);
    return estimate;
  };
  const TransferSettings finest;  // the program's choice, which leaks least
  const ident::TransferEstimate best = problem.estimate(0, finest);
  ident::ModeOptions options = study.modes;
  options.method = ident::ModeMethod::automatic;
  for (const auto& mode : ident::identify_modes(best.function, options).modes) {
    if (!mode.flags.empty() || !(mode.loss_factor_sigma > 0.0)) continue;
    problem.truth.push_back(mode);
    problem.reference_error += std::pow(mode.loss_factor_sigma / mode.loss_factor, 2);
  }
  if (problem.truth.empty()) {
    throw Error(fmt::format(
        "tradeoff: {}: no mode without a flag that others could be compared with; longer records are needed",
        name));
  }
  problem.reference_error = std::sqrt(problem.reference_error / static_cast<double>(problem.truth.size()));
  problem.reference = fmt::format(
      "the {} modes without flags of the program's own choice ({}); their standard errors are the "
      "reference's",
      problem.truth.size(), name_of(best));
  return problem;
}

TradeoffChart tradeoff_resolution(const TransferProblem& problem, const TradeoffRun& run) {
  TradeoffChart chart = chart_of(problem, problem.name);
  for (const auto& method : methods()) {
    for (const double segments : {120.0, 60.0, 30.0, 15.0, 7.5, 5.0, 3.0}) {
      run.progress(fmt::format("transfer: {}, {}, {:g} segments", problem.name, method.name, segments));
      add_row(problem, method, segments / problem.duration, run, chart);
    }
  }
  add_default_row(problem, run, chart);
  sort_rows(chart);
  mark_pareto(chart);
  return chart;
}

TradeoffChart tradeoff_record_length(double noise, long draws, const TradeoffRun& run) {
  TradeoffChart chart;
  for (const double duration : {7.5, 15.0, 30.0, 60.0, 120.0}) {
    const TransferProblem problem = shaken_wire_problem(duration, noise, draws);
    if (chart.rows.empty())
      chart = chart_of(problem, fmt::format("shaken wire at {:g} % noise over record length", 100.0 * noise));
    for (const auto& method : methods()) {
      if (method.settings.welch.overlap != ident::WelchOptions{}.overlap) continue;
      run.progress(fmt::format("transfer: {}, {}", problem.name, method.name));
      TradeoffRow row{method.name, "record [s]", duration};
      row.error = loss_factor_error(problem, estimate_all(problem, method.settings, run.timing, row.seconds));
      chart.rows.push_back(row);
    }
  }
  sort_rows(chart);
  chart.notes.push_back("Time is that of the computation, not of the measurement.");
  mark_pareto(chart);
  return chart;
}

std::vector<TradeoffChart> tradeoff_transfer(const TradeoffRun& run) {
  constexpr long draws = 3;
  return {tradeoff_resolution(shaken_wire_problem(30.0, 0.001, draws), run),
          tradeoff_resolution(shaken_wire_problem(30.0, 0.01, draws), run),
          tradeoff_record_length(0.01, draws, run)};
}

}  // namespace struna::apps
