#include "apps/tradeoff_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

namespace struna::apps {
namespace {

bool beats(const TradeoffChart& chart, const TradeoffRow& other, const TradeoffRow& row) {
  const double there = told_error(chart, other);
  const double here = told_error(chart, row);
  if (!std::isfinite(there)) return false;
  return (other.seconds < row.seconds && there <= here) || (other.seconds <= row.seconds && there < here);
}

const TradeoffRow* default_of(const TradeoffChart& chart) {
  for (const auto& row : chart.rows) {
    if (row.is_default) return &row;
  }
  return nullptr;
}

/// The quickest row whose error is at most `error`.
const TradeoffRow* quickest(const TradeoffChart& chart, double error) {
  const TradeoffRow* best = nullptr;
  for (const auto& row : chart.rows) {
    if (row.error <= error && (best == nullptr || row.seconds < best->seconds)) best = &row;
  }
  return best;
}

const TradeoffRow* most_accurate(const TradeoffChart& chart) {
  const TradeoffRow* best = nullptr;
  for (const auto& row : chart.rows) {
    if (std::isfinite(row.error) && (best == nullptr || row.error < best->error)) best = &row;
  }
  return best;
}

std::string row_text(const TradeoffChart& chart, const TradeoffRow& row) {
  return fmt::format("{}, {} ({} in {})", row.method, row_label(row), percent_text(told_error(chart, row)),
                     seconds_text(row.seconds));
}

std::string default_text(const TradeoffChart& chart) {
  const TradeoffRow* const usual = default_of(chart);
  if (usual == nullptr) return "";
  const std::string what = fmt::format(" The default gives {} in {}", percent_text(told_error(chart, *usual)),
                                       seconds_text(usual->seconds));
  const auto better = better_than_default(chart);
  if (better.empty()) {
    return what + (usual->pareto ? " and lies on the front."
                                 : "; nothing is both quicker and more accurate by more than 1.5.");
  }
  const auto first = std::min_element(better.begin(), better.end(), [](const auto& a, const auto& b) {
    return a.error * a.seconds < b.error * b.seconds;
  });
  return fmt::format("{}; {} is both quicker and more accurate, {:.2g} and {:.2g} times.", what,
                     row_text(chart, *first), usual->seconds / first->seconds,
                     told_error(chart, *usual) / told_error(chart, *first));
}

}  // namespace

double told_error(const TradeoffChart& chart, const TradeoffRow& row) {
  return std::isfinite(row.error) ? std::max(row.error, chart.reference_error) : row.error;
}

void mark_pareto(TradeoffChart& chart) {
  for (auto& row : chart.rows) {
    row.pareto = std::isfinite(row.error) &&
                 std::none_of(chart.rows.begin(), chart.rows.end(),
                              [&](const TradeoffRow& other) { return beats(chart, other, row); });
  }
}

std::vector<TradeoffRow> better_than_default(const TradeoffChart& chart, double factor) {
  std::vector<TradeoffRow> better;
  const TradeoffRow* const usual = default_of(chart);
  if (usual == nullptr) return better;
  for (const auto& row : chart.rows) {
    const bool finite = std::isfinite(row.error);
    if (finite && row.seconds * factor < usual->seconds &&
        told_error(chart, row) * factor < told_error(chart, *usual)) {
      better.push_back(row);
    }
  }
  return better;
}

std::string advice(const TradeoffChart& chart) {
  const TradeoffRow* const enough = quickest(chart, chart.target);
  const std::string goal =
      fmt::format("For {} in {} ({})", percent_text(chart.target), chart.quantity, chart.problem);
  if (enough != nullptr)
    return fmt::format("{} take {}.", goal, row_text(chart, *enough)) + default_text(chart);
  const TradeoffRow* const best = most_accurate(chart);
  if (best == nullptr) return goal + ": nothing here gave a result.";
  return fmt::format("{}: nothing here reaches it; nearest is {}.", goal, row_text(chart, *best)) +
         default_text(chart);
}

std::string tradeoff_csv(const std::vector<TradeoffChart>& charts) {
  std::string text = "stage,problem,method,knob,value,error,time_s,pareto,default,quantity,reference_error\n";
  for (const auto& chart : charts) {
    for (const auto& row : chart.rows) {
      const std::string error = std::isfinite(row.error) ? fmt::format("{:.4g}", row.error) : "";
      text += fmt::format("{},{},{},{},{:.9g},{},{:.4g},{},{},{},{:.3g}\n", chart.stage, chart_title(chart),
                          row.method, row.knob, row.value, error, row.seconds, row.pareto ? 1 : 0,
                          row.is_default ? 1 : 0, chart.quantity, chart.reference_error);
    }
  }
  return text;
}

std::string chart_title(const TradeoffChart& chart) {
  return chart.problem + ": " + chart.quantity;
}

std::string knob_name(const std::string& knob) {
  return knob.substr(0, knob.find(" ["));
}

std::string row_label(const TradeoffRow& row) {
  const std::size_t open = row.knob.find(" [");
  std::string unit;
  if (open != std::string::npos) unit = row.knob.substr(open + 2, row.knob.find(']', open) - open - 2);
  return fmt::format("{} = {:.4g}{}", knob_name(row.knob), row.value,
                     unit.empty() || unit == "-" ? "" : " " + unit);
}

std::string seconds_text(double seconds) {
  if (seconds >= 1.0) return fmt::format("{:.3g} s", seconds);
  return seconds >= 1e-3 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} us", 1e6 * seconds);
}

std::string percent_text(double share) {
  return fmt::format("{:.2g} %", 100.0 * share);
}

double best_seconds(const Timing& timing, const std::function<void()>& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  double best = std::numeric_limits<double>::infinity();
  const double begin = now();
  for (int run = 0; run < timing.runs && (run == 0 || now() - begin < timing.budget); ++run) {
    const double start = now();
    work();
    best = std::min(best, now() - start);
  }
  return best;
}

}  // namespace struna::apps
