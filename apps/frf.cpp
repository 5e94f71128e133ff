#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/measured_transfer.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

struct FrfArguments {
  std::vector<std::string> records;
  std::string input;
  std::vector<std::string> outputs;
  std::string to;
  std::string form = "as-measured";
  std::string estimator = "auto";
  std::string window = "auto";
  std::string band;
  std::vector<std::string> channels;
  std::vector<std::string> clamp_masses;
  TransferSettings settings;
};

double number_of(const std::string& option, std::string_view text) {
  double value = 0.0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError(fmt::format("{}: '{}' is not a number", option, text));
  return value;
}

/// NAME:key=value,key=value …
void add_correction(const std::string& text, std::map<std::string, ident::ChannelCorrection>& corrections) {
  const auto colon = text.find(':');
  if (colon == 0 || colon == std::string::npos)
    throw UsageError(
        fmt::format("--channel: write NAME:key=value,..., such as force:sign=-1,delay=1e-4, got '{}'", text));
  ident::ChannelCorrection& correction = corrections[text.substr(0, colon)];
  for (std::size_t begin = colon + 1; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string pair = text.substr(begin, end - begin);
    const std::string key = pair.substr(0, pair.find('='));
    const std::string value = key.size() < pair.size() ? pair.substr(key.size() + 1) : "";
    if (key == "sensitivity")
      correction.sensitivity = number_of("--channel sensitivity", value);
    else if (key == "sign")
      correction.sign = number_of("--channel sign", value);
    else if (key == "delay")
      correction.delay = number_of("--channel delay", value);
    else if (key == "unit" && !value.empty())
      correction.unit = value;
    else
      throw UsageError(fmt::format("--channel: keys are sensitivity, sign, delay and unit, got '{}'", pair));
    begin = end + 1;
  }
}

/// NAME:KG
void add_clamp_mass(const std::string& text, std::map<std::string, double>& masses) {
  const auto colon = text.rfind(':');
  if (colon == 0 || colon == std::string::npos)
    throw UsageError(fmt::format("--clamp-mass: write NAME:KG, such as force_y:0.012, got '{}'", text));
  masses[text.substr(0, colon)] = number_of("--clamp-mass", std::string_view(text).substr(colon + 1));
}

Table outputs_table(const ident::TransferFunction& tf) {
  Table table{{"output", "form", "unit", "largest", "at [Hz]", "mean coherence", "median sigma/|H| [%]"}, {}};
  for (const auto& output : tf.outputs) {
    Eigen::Index at = 0;
    const double largest = output.value.cwiseAbs().maxCoeff(&at);
    std::string coherence = "-";
    std::string sigma = "-";
    if (output.coherence.size() > 0) coherence = fmt::format("{:.3f}", output.coherence.mean());
    if (output.sigma.size() > 0) {
      Eigen::VectorXd relative = output.sigma.cwiseQuotient(output.value.cwiseAbs());
      std::nth_element(relative.begin(), relative.begin() + relative.size() / 2, relative.end());
      sigma = fmt::format("{:.2g}", 100.0 * relative[relative.size() / 2]);
    }
    table.rows.push_back({output.name, ident::to_string(output.kind), output.unit,
                          fmt::format("{:.4g}", largest), fmt::format("{:.6g}", tf.frequency_hz[at]),
                          coherence, sigma});
  }
  return table;
}

void run_frf(FrfArguments& arguments) {
  TransferSettings& settings = arguments.settings;
  const ident::EstimatorWord chosen = option_value("--estimator", arguments.estimator, ident::estimator_word);
  settings.method = chosen.method;
  settings.estimator = chosen.ratio;
  settings.welch.window = option_value("--window", arguments.window, ident::window_kind);
  if (arguments.form != "as-measured")
    settings.form = option_value("--form", arguments.form, ident::frf_kind);
  if (!arguments.band.empty()) settings.band = parse_band(arguments.band);
  std::map<std::string, ident::ChannelCorrection> corrections;
  for (const auto& channel : arguments.channels) add_correction(channel, corrections);
  for (const auto& mass : arguments.clamp_masses) add_clamp_mass(mass, settings.clamp_mass);

  progress(fmt::format("reading {} record(s)", arguments.records.size()));
  const MeasuredTransfer measured = blaming(arguments.records, [&] {
    return measure_transfer(arguments.records, arguments.input, arguments.outputs, corrections, settings);
  });
  for (const auto& warning : measured.warnings) warn(warning);
  ident::write_transfer_function(measured.function, arguments.to);

  Table table{{"setting", "value"}, {}};
  for (const auto& [name, value] : transfer_settings_shown(measured)) table.rows.push_back({name, value});
  print(table);
  print("");
  print(outputs_table(measured.function));
}

}  // namespace

void add_frf(CLI::App& app) {
  const auto arguments = std::make_shared<FrfArguments>();
  ident::WelchOptions& welch = arguments->settings.welch;
  CLI::App* const frf =
      app.add_subcommand("frf", "transfer functions with coherence and standard deviation from records");
  frf->add_option("RECORDS.csv", arguments->records, "records; several are repeats of one setup, averaged")
      ->type_name("")
      ->required();
  frf->add_option("--input", arguments->input, "column of the input")->type_name("NAME")->required();
  frf->add_option("--output", arguments->outputs, "column of an output; may be repeated")
      ->type_name("NAME")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  frf->add_option("-o", arguments->to, "transfer function to write")
      ->type_name(written_file + std::string(".csv"))
      ->required();
  frf->add_option(
         "--form", arguments->form,
         "as-measured (default), dynamic-stiffness, impedance, apparent-mass, receptance, mobility or "
         "accelerance: changes the "
         "motion quantity; inverts only a drive-point function with one output")
      ->type_name("WORD");
  frf->add_option(
         "--estimator", arguments->estimator,
         "auto (default: by the records), local, local-polynomial or periodic, none of which leaks; Welch's "
         "averages: welch or h1 (noise on the output), h2 (on the input), hv (on both), amplitude-ratio")
      ->type_name("WORD");
  frf->add_option(
         "--drive-signal", arguments->settings.drive_signal,
         "column of the signal that drives the shaker, if recorded: noise on the input then biases nothing "
         "(local and periodic estimators)")
      ->type_name("NAME");
  frf->add_option("--resolution", welch.resolution_hz, "line spacing; default: from the records' duration")
      ->type_name("HZ")
      ->check(refusal_of_hz);
  frf->add_option("--band", arguments->band, "lines to write [Hz]; default: all above 0 Hz")
      ->type_name("LO:HI");
  const CLI::Option* const overlap =
      frf->add_option("--overlap", welch.overlap, "of neighbouring segments, 0 to 0.9; default 2/3")
          ->check(CLI::Range(0.0, 0.9).description(""))
          ->type_name("FRACTION");
  frf->add_option(
         "--window", arguments->window,
         "auto (default), hann, rectangular (alone: one segment per record) or exponential (impact tests)")
      ->type_name("WORD");
  frf->add_flag("--impact", welch.impact, "hammer test: each record holds one hit and is one segment");
  const CLI::Option* const end =
      frf->add_option("--exponential-end", welch.exponential_end,
                      "value of the exponential window at the end of the record, 0 to 1; default 0.01")
          ->type_name("FRACTION");
  frf->add_option("--channel", arguments->channels,
                  "corrects a column before use; keys: sensitivity, sign, delay [s], unit")
      ->type_name("NAME:KEY=VALUE,...")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  frf->add_option("--clamp-mass", arguments->clamp_masses,
                  "takes the mass that moves with the input between force cell and wire out of an output")
      ->type_name("NAME:KG")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  frf->add_option("--fixture", arguments->settings.fixture,
                  "takes the transfer function of the empty fixture (the same run without the wire) out")
      ->type_name(read_file + std::string(".csv"));
  frf->footer(
      "Examples:\n"
      "  struna frf records.csv --input displacement --output force_y --output force_z -o trfam.csv --band "
      "10:1000\n"
      "  struna frf hit_1.csv hit_2.csv --input force --output acceleration --impact -o trfam.csv");
  frf->callback([arguments, overlap, end] {
    if (end->count() > 0 && arguments->window != "exponential")
      throw UsageError("--exponential-end goes with --window exponential");
    if (overlap->count() > 0 && arguments->settings.welch.impact)
      throw UsageError("--overlap: a hit is one segment, which overlaps with none");
    run_frf(*arguments);
  });
}

}  // namespace struna::apps
