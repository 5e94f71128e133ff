#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/provenance.hpp"
#include "apps/repeated_records.hpp"
#include "apps/report.hpp"
#include "ident/atomic_file.hpp"
#include "ident/mode_file.hpp"
#include "ident/mode_identification.hpp"
#include "ident/references.hpp"
#include "ident/stabilisation_file.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

struct ModesArguments {
  std::vector<std::string> from;
  std::vector<std::string> references;
  std::string to;
  std::string stabilisation;
  std::string report;
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
               "circle f [Hz]", "circle loss factor", "orders", "flags"},
              {}};
  for (std::size_t r = 0; r < set.modes.size(); ++r) {
    const ident::Mode& mode = set.modes[r];
    table.rows.push_back({fmt::format("{}", r + 1), number(mode.natural_frequency_hz, "{:.4f}"),
                          number(mode.natural_frequency_sigma, "{:.4f}"),
                          fmt::format("{:.3f} - {:.3f}", mode.lower_half_power_hz, mode.upper_half_power_hz),
                          number(mode.loss_factor, "{:.6f}"), number(mode.loss_factor_sigma, "{:.6f}"),
                          number(mode.damping_ratio, "{:.6f}"),
                          number(mode.circle_natural_frequency_hz, "{:.4f}"),
                          number(mode.circle_loss_factor, "{:.6f}"),
                          mode.orders > 0 ? fmt::format("{}/{}", mode.stable_orders, mode.orders) : "-",
                          ident::flag_words(mode.flags)});
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

/// Why there may be none, for the user to mend.
std::string no_mode_found(const std::string& file, const ident::TransferFunction& tf,
                          const ident::ModeOptions& options) {
  ident::TransferFunction conjugate = tf;
  for (auto& output : conjugate.outputs) output.value = output.value.conjugate().eval();
  const std::size_t found = ident::identify_modes(conjugate, options).modes.size();
  if (found > 0)
    return fmt::format(
        "{}: no mode, but {} with the sign of the imaginary parts reversed: they follow the time factor "
        "e^(-i omega t), e^(+i omega t) is needed; reverse the sign of the _im columns",
        file, found);
  std::string noise;
  for (const auto& output : tf.outputs) {
    if (output.sigma.size() == 0) continue;
    const double drowned = (output.sigma.array() > 0.5 * output.value.array().abs()).cast<double>().mean();
    if (drowned > 0.5) noise += (noise.empty() ? "" : ", ") + output.name;
  }
  if (!noise.empty())
    return fmt::format(
        "{}: no mode: noise is more than half of the value at most lines of {}; more averages, stronger "
        "excitation or a narrower --band are needed",
        file, noise);
  return fmt::format(
      "{}: no mode: no resonance stands out; --band tells where to look, --frequencies which ones to try",
      file);
}

/// One function of all files, each a reference.
ident::TransferFunction read_references(const ModesArguments& arguments, std::vector<std::string>& warnings) {
  const auto& names = arguments.references;
  if (!names.empty() && names.size() != arguments.from.size())
    throw UsageError(fmt::format("--references: a name for each of the {} files, got {}",
                                 arguments.from.size(), names.size()));
  refuse_repeated_records(arguments.from);
  std::vector<ident::NamedReference> references;
  for (std::size_t k = 0; k < arguments.from.size(); ++k) {
    const std::string& file = arguments.from[k];
    const std::string name = names.empty() ? std::filesystem::path(file).stem().string() : names[k];
    references.push_back({name, file, ident::read_transfer_function(file, &warnings)});
  }
  return ident::combine_references(references);
}

/// Transfer functions, modes, circles and the stabilisation chart on one page.
std::string modes_report(const ModesArguments& arguments, const ident::TransferFunction& tf,
                         const ident::ModeSet& set, const std::vector<std::string>& warnings) {
  ReportContent content;
  content.title = "Modes of " + std::filesystem::path(arguments.from.front()).filename().string();
  content.command = fmt::format("struna modes {} -o {} --method {} --damping {}{}",
                                fmt::join(arguments.from, " "), arguments.to, arguments.method,
                                arguments.damping, arguments.band.empty() ? "" : " --band " + arguments.band);
  if (!arguments.frequencies.empty())
    content.command += fmt::format(" --frequencies {}", fmt::join(arguments.frequencies, ","));
  if (!arguments.extra.empty()) content.command += fmt::format(" --add {}", fmt::join(arguments.extra, ","));
  if (!arguments.references.empty())
    content.command += fmt::format(" --references {}", fmt::join(arguments.references, ","));
  content.warnings = warnings;
  content.settings = {{"mode method", arguments.method}, {"damping", arguments.damping}};
  content.measured = tf;
  content.modes = set;
  const auto& lines = tf.frequency_hz;
  const Band band =
      arguments.band.empty() ? Band{lines.minCoeff(), lines.maxCoeff()} : parse_band(arguments.band);
  content.identified.provenance = provenance(arguments.from, band.lo_hz, band.hi_hz);
  return render_report(content);
}

/// Told before the files are read.
void check_stabilisation(const ModesArguments& arguments, ident::ModeMethod method) {
  if (arguments.stabilisation.empty()) return;
  if (method != ident::ModeMethod::automatic && method != ident::ModeMethod::multi)
    throw UsageError("--stabilisation: only with --method auto or multi, got " + arguments.method);
}

void run_modes(const ModesArguments& arguments) {
  const ident::ModeOptions options = options_of(arguments);
  check_stabilisation(arguments, options.method);
  std::vector<std::string> warnings;
  const ident::TransferFunction tf = read_references(arguments, warnings);
  for (const std::string& warning : warnings) warn(warning);
  const std::string& file = arguments.from.front();
  progress(fmt::format("modes of {} outputs, {} lines", tf.outputs.size(), tf.lines()));
  const ident::ModeSet set = blaming(arguments.from, [&] { return ident::identify_modes(tf, options); });
  if (set.modes.empty()) {
    warnings.push_back(no_mode_found(file, tf, options));
    warn(warnings.back());
  }
  const std::string page = arguments.report.empty() ? "" : modes_report(arguments, tf, set, warnings);
  ident::write_modes(set, arguments.to);
  if (!arguments.stabilisation.empty())
    ident::write_stabilisation(set.stabilisation, arguments.stabilisation);
  if (!arguments.report.empty()) ident::write_atomically(arguments.report, page);
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
  modes
      ->add_option("TRFAM.csv", arguments->from,
                   "transfer functions, as `struna frf` writes them; several are references of one "
                   "structure, shaken along one direction after the other")
      ->type_name("")
      ->required();
  modes->add_option("-o", arguments->to, "modes to write")
      ->type_name(written_file + std::string(".csv"))
      ->required();
  modes
      ->add_option("--references", arguments->references,
                   "a name for each of several files, best its direction; default: the files' names")
      ->delimiter(',')
      ->type_name("NAME,NAME,...")
      ->allow_extra_args(false);
  modes->add_option("--band", arguments->band, "lines to use [Hz]; default: all above 0 Hz")
      ->type_name("LO:HI");
  modes
      ->add_option(
          "--method", arguments->method,
          "auto (default: circles start and illustrate, a multi-mode fit refines), circle, half-power "
          "or multi")
      ->type_name("WORD");
  modes->add_option("--damping", arguments->damping, "structural (default) or viscous")->type_name("WORD");
  modes
      ->add_option("--stabilisation", arguments->stabilisation,
                   "poles of models of rising order to write: which stay, and in which stable column")
      ->type_name(written_file + std::string(".csv"));
  modes
      ->add_option("--report", arguments->report,
                   "page to write: transfer functions, modes, circles, stabilisation chart")
      ->type_name(written_file + std::string(".html"));
  CLI::Option* const only =
      modes->add_option("--frequencies", arguments->frequencies, "these resonances only");
  only->delimiter(',')->allow_extra_args(false)->type_name("HZ,HZ,...");
  modes->add_option("--add", arguments->extra, "these besides the ones found")
      ->delimiter(',')
      ->type_name("HZ,HZ,...")
      ->allow_extra_args(false)
      ->excludes(only);
  modes->footer(
      "Examples:\n"
      "  struna modes trfam.csv -o modes.csv\n"
      "  struna modes trfam.csv -o modes.csv --band 10:900 --method circle\n"
      "  struna modes trfam.csv -o modes.csv --add 616.4\n"
      "  struna modes trfam.csv -o modes.csv --stabilisation poles.csv --report modes.html\n"
      "  struna modes y.csv z.csv -o modes.csv");
  modes->callback([arguments] { run_modes(*arguments); });
}

}  // namespace struna::apps
