#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "ident/mode_file.hpp"
#include "ident/mode_identification.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

struct ModesArguments {
  std::string from;
  std::string to;
  std::string method = "auto";
  std::string damping = "structural";
  std::string band;
  std::vector<double> frequencies;
  std::vector<double> extra;
};

std::string number(double value, const char* pattern) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(pattern), value);
}

Table modes_table(const ident::ModeSet& set) {
  Table table{{"mode", "f [Hz]", "+-", "half-power band [Hz]", "loss factor", "+-", "damping ratio",
               "circle f [Hz]", "circle loss factor", "flags"},
              {}};
  for (std::size_t r = 0; r < set.modes.size(); ++r) {
    const ident::Mode& mode = set.modes[r];
    table.rows.push_back({fmt::format("{}", r + 1), number(mode.natural_frequency_hz, "{:.4f}"),
                          number(mode.natural_frequency_sigma, "{:.4f}"),
                          fmt::format("{:.3f} - {:.3f}", mode.lower_half_power_hz, mode.upper_half_power_hz),
                          number(mode.loss_factor, "{:.6f}"), number(mode.loss_factor_sigma, "{:.6f}"),
                          number(mode.damping_ratio, "{:.6f}"),
                          number(mode.circle_natural_frequency_hz, "{:.4f}"),
                          number(mode.circle_loss_factor, "{:.6f}"), ident::flag_words(mode)});
  }
  return table;
}

ident::ModeOptions options_of(const ModesArguments& arguments) {
  ident::ModeOptions options;
  options.method = option_value("--method", arguments.method, ident::mode_method);
  options.damping = option_value("--damping", arguments.damping, fem::damping_kind);
  options.frequencies_hz = arguments.frequencies;
  options.extra_hz = arguments.extra;
  if (!arguments.band.empty()) {
    const Band band = parse_band(arguments.band);
    options.band_lo_hz = band.lo_hz;
    options.band_hi_hz = band.hi_hz;
  }
  return options;
}

void run_modes(const ModesArguments& arguments) {
  const ident::ModeOptions options = options_of(arguments);
  std::vector<std::string> warnings;
  const ident::TransferFunction tf = ident::read_transfer_function(arguments.from, &warnings);
  for (const std::string& warning : warnings) warn(warning);
  progress(fmt::format("modes of {} outputs, {} lines", tf.outputs.size(), tf.lines()));
  const ident::ModeSet set = blaming({arguments.from}, [&] { return ident::identify_modes(tf, options); });
  ident::write_modes(set, arguments.to);
  print(modes_table(set));
  if (set.rejected.empty()) return;
  print("");
  Table rejected{{"no mode [Hz]", "reason"}, {}};
  for (const ident::RejectedCandidate& candidate : set.rejected)
    rejected.rows.push_back({fmt::format("{:.3f}", candidate.frequency_hz), candidate.reason});
  print(rejected);
}

}  // namespace

void add_modes(CLI::App& app) {
  const auto arguments = std::make_shared<ModesArguments>();
  CLI::App* const modes =
      app.add_subcommand("modes", "natural and half-power frequencies, loss factors, modal constants");
  modes->add_option("TRFAM", arguments->from, "transfer function CSV, as `struna frf` writes it")->required();
  modes->add_option("-o", arguments->to, "modes CSV to write")->required();
  modes->add_option("--band", arguments->band, "LO:HI, lines to use [Hz]");
  modes->add_option(
      "--method", arguments->method,
      "auto, circle, half-power or multi; auto: circles start and illustrate, a multi-mode fit refines");
  modes->add_option("--damping", arguments->damping, "structural or viscous");
  CLI::Option* const only =
      modes->add_option("--frequencies", arguments->frequencies, "F1,F2,...: these resonances only [Hz]");
  only->delimiter(',')->allow_extra_args(false);
  modes->add_option("--add", arguments->extra, "F1,F2,...: these besides the ones found [Hz]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->excludes(only);
  modes->footer(
      "Examples:\n"
      "  struna modes trfam.csv -o modes.csv\n"
      "  struna modes trfam.csv -o modes.csv --band 10:900 --method circle\n"
      "  struna modes trfam.csv -o modes.csv --add 616.4");
  modes->callback([arguments] { run_modes(*arguments); });
}

}  // namespace struna::apps
