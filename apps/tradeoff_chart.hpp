#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace struna::apps {

/// One way to a result: what it costs and how far off it is.
struct TradeoffRow {
  std::string method;
  std::string knob;         ///< what is turned, with its unit: "elements [-]", "step [s]"
  double value = 0.0;       ///< of the knob
  double error = 0.0;       ///< of the chart's quantity, >= 0
  double seconds = 0.0;     ///< processor time of one thread [s]
  bool is_default = false;  ///< what the program does when nothing is asked for
  bool pareto = false;      ///< no other row of the chart is quicker and as accurate; see mark_pareto
};

/// Error against time of all methods for one quantity of one problem.
struct TradeoffChart {
  std::string stage;
  std::string problem;      ///< with the quantity, tells a chart from the others: "eight modes at 1 % noise"
  std::string quantity;     ///< what the error is of: "loss factor"
  std::string error_label;  ///< how it is taken: "rms over the modes of the relative error"
  double target = 0.01;     ///< error that the advice is about
  std::string reference;    ///< what errors are taken against, and what shows that it has converged
  double reference_error = 0.0;  ///< the reference's own, estimated; errors below it are not told apart
  std::vector<TradeoffRow> rows;
  std::vector<std::string> notes;
};

/// The error as far as the reference can tell it: at least reference_error.
double told_error(const TradeoffChart& chart, const TradeoffRow& row);

/// Sets `pareto` on the rows that no other row beats: is quicker and at least as accurate, or as quick and
/// more accurate, by told_error(). Errors that are not finite are never on the front.
void mark_pareto(TradeoffChart& chart);

/// Rows that are both quicker and more accurate than the chart's default by more than `factor`.
std::vector<TradeoffRow> better_than_default(const TradeoffChart& chart, double factor = 1.5);

/// One sentence from the rows: what to take for the chart's target, and where the default stands.
std::string advice(const TradeoffChart& chart);

/// tradeoff.csv: stage,problem,method,knob,value,error,time_s,pareto,default, then
/// quantity,reference_error; `problem` includes the quantity, so that it names one chart. An error that is
/// not finite (a run that diverged) is an empty field.
std::string tradeoff_csv(const std::vector<TradeoffChart>& charts);

std::string chart_title(const TradeoffChart& chart);  ///< "PROBLEM: QUANTITY"
std::string row_label(const TradeoffRow& row);        ///< "elements = 28", "step = 1e-05 s"
std::string knob_name(const std::string& knob);       ///< "elements [-]" -> "elements"
std::string seconds_text(double seconds);             ///< "3.2 ms"
std::string percent_text(double share);               ///< "1 %", "2e-04 %"

/// How much time goes into timing.
struct Timing {
  int runs = 3;         ///< at most
  double budget = 0.1;  ///< [s]; no further run is begun beyond it
};

/// Processor time of the shortest of several runs of `work` [s]: what one thread takes on an idle machine.
double best_seconds(const Timing& timing, const std::function<void()>& work);

/// What every stage gets: how long to time, and whom to tell what is being done.
struct TradeoffRun {
  Timing timing;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

}  // namespace struna::apps
