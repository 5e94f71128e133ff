#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/predict.hpp"
#include "ident/comparison.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

struct CompareArguments {
  std::string measured;
  std::string predicted;
  std::string to;
  std::string band;
  bool peaks = false;
};

ident::TransferFunction read_with_warnings(const std::string& file) {
  std::vector<std::string> warnings;
  ident::TransferFunction tf = ident::read_transfer_function(file, &warnings);
  for (const std::string& warning : warnings) warn(warning);
  return tf;
}

/// What is not defined, as the error of an output that is predicted as zero, is a dash.
std::string shown(double value, const char* pattern) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(pattern), value) : "-";
}

Table outputs_table(const ident::Comparison& comparison) {
  Table table{{"output", "FRAC", "error [dB]", "mean [dB]", "largest [dB]", "lines", "peaks", "peak f [%]",
               "peak level [dB]"},
              {}};
  for (const ident::OutputComparison& output : comparison.outputs) {
    table.rows.push_back({output.output, shown(output.frac, "{:.5f}"),
                          shown(output.log_magnitude_error_db, "{:.3f}"), shown(output.mean_db, "{:+.3f}"),
                          shown(output.largest_db, "{:.2f}"), fmt::format("{}", output.lines),
                          fmt::format("{}", output.peaks.size()),
                          shown(100.0 * peak_frequency_error(output), "{:.3f}"),
                          shown(peak_amplitude_error_db(output), "{:.2f}")});
  }
  return table;
}

Table peaks_table(const ident::Comparison& comparison) {
  Table table{{"output", "measured peak [Hz]", "predicted [Hz]", "difference [%]", "amplitude [dB]"}, {}};
  for (const ident::OutputComparison& output : comparison.outputs) {
    for (const ident::PeakDifference& peak : output.peaks) {
      table.rows.push_back({output.output, fmt::format("{:.3f}", peak.measured_hz),
                            shown(peak.predicted_hz, "{:.3f}"),
                            shown(100.0 * (peak.predicted_hz / peak.measured_hz - 1.0), "{:+.3f}"),
                            shown(peak.amplitude_db, "{:+.2f}")});
    }
  }
  return table;
}

void run_compare(const CompareArguments& arguments) {
  const Band band = arguments.band.empty() ? Band{} : parse_band(arguments.band);
  const ident::TransferFunction measured = read_with_warnings(arguments.measured);
  const ident::TransferFunction predicted = read_with_warnings(arguments.predicted);
  const ident::Comparison comparison = blaming({arguments.predicted, arguments.measured}, [&] {
    return ident::compare(measured, predicted, band.lo_hz, band.hi_hz);
  });
  for (const std::string& name : comparison.not_compared) {
    warn(fmt::format("{}: has no output {}: not compared", arguments.predicted, name));
  }
  if (const auto warning = window_warning(measured.exponential_decay, predicted.exponential_decay)) {
    warn(arguments.measured + ": " + *warning);
  }
  if (!arguments.to.empty()) ident::write_comparison(comparison, arguments.to);

  print(fmt::format("{:.6g} to {:.6g} Hz", comparison.lo_hz, comparison.hi_hz));
  print(outputs_table(comparison));
  if (arguments.peaks) {
    print("");
    print(peaks_table(comparison));
  }
}

}  // namespace

void add_compare(CLI::App& app) {
  const auto arguments = std::make_shared<CompareArguments>();
  CLI::App* const compare = app.add_subcommand(
      "compare", "FRAC, level error and peaks of a predicted against a measured transfer function");
  compare->add_option("MEASURED.csv", arguments->measured, "measured transfer function")
      ->type_name("")
      ->required();
  compare
      ->add_option("PREDICTED.csv", arguments->predicted,
                   "predicted one; outputs of the same names are compared")
      ->type_name("")
      ->required();
  compare->add_option("-o", arguments->to, "comparison to write")
      ->type_name(written_file + std::string(".csv"));
  compare->add_option("--band", arguments->band, "lines to compare [Hz]; default: all that both have")
      ->type_name("LO:HI");
  compare->add_flag("--peaks", arguments->peaks, "list every peak, measured against predicted");
  compare->footer(
      "Example:\n"
      "  struna compare trfam.csv predicted.csv -o comparison.csv --band 10:1000");
  compare->callback([arguments] { run_compare(*arguments); });
}

}  // namespace struna::apps
