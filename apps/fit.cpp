#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/commands.hpp"
#include "apps/console.hpp"
#include "apps/provenance.hpp"
#include "apps/scene_file.hpp"
#include "apps/scene_fit.hpp"
#include "ident/mode_file.hpp"
#include "ident/parameter_file.hpp"

namespace struna::apps {
namespace {

struct FitArguments {
  std::string scene;
  std::string modes;
  std::string to;
  std::string band;
  std::string modulus_range;
  bool torsion_constant = false;
  std::optional<double> tolerance;
  bool explain = false;
  ident::FitOptions options;
};

/// Throws Error unless a number of the body goes by this name.
int checked_number(const std::string& name) {
  const std::vector<std::string> known = fem::fittable_numbers();
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw Error(fmt::format("one of {}, got \"{}\"", fmt::join(known, ", "), name));
  return 0;
}

/// Index of the curve's point at this frequency, -1 when the mode is not trusted for it.
Eigen::Index point_at(const ident::IdentifiedCurve& curve, double f_hz) {
  for (Eigen::Index i = 0; i < curve.frequency_hz.size(); ++i) {
    if (curve.frequency_hz[i] == f_hz) return i;
  }
  return -1;
}

std::string model_modes(const ident::Pair& pair) {
  std::vector<int> numbers = pair.model;
  for (int& number : numbers) ++number;
  return fmt::format("{}", fmt::join(numbers, "+"));
}

Table modes_table(const ident::ModeSet& modes, const ident::IdentifiedParameters& identified) {
  Table table{{"mode", "measured [Hz]", "model mode", "MAC", "E [GPa]", "+-", "scene +-", "loss factor", "+-",
               "Kramers-Kronig"},
              {}};
  for (const ident::Pair& pair : identified.pairing.pairs) {
    const double f = modes.modes[static_cast<std::size_t>(pair.measured)].natural_frequency_hz;
    std::vector<std::string> row = {fmt::format("{}", pair.measured + 1), fmt::format("{:.3f}", f),
                                    model_modes(pair),
                                    std::isnan(pair.mac) ? "-" : fmt::format("{:.3f}", pair.mac)};
    const Eigen::Index e = point_at(identified.modulus, f);
    const Eigen::VectorXd& scene = identified.modulus.scene_sigma;
    row.push_back(e < 0 ? "-" : fmt::format("{:.3f}", 1e-9 * identified.modulus.value[e]));
    row.push_back(e < 0 ? "-" : fmt::format("{:.3f}", 1e-9 * identified.modulus.sigma[e]));
    row.push_back(e < 0 || scene.size() == 0 ? "-" : fmt::format("{:.3f}", 1e-9 * scene[e]));
    const Eigen::Index eta = point_at(identified.loss_factor, f);
    row.push_back(eta < 0 ? "-" : fmt::format("{:.5f}", identified.loss_factor.value[eta]));
    row.push_back(eta < 0 ? "-" : fmt::format("{:.5f}", identified.loss_factor.sigma[eta]));
    row.push_back(eta < 0 ? "-" : fmt::format("{:.4f}", identified.kramers_kronig_loss_factor[eta]));
    table.rows.push_back(row);
  }
  return table;
}

Table laws_table(const ident::IdentifiedParameters& identified) {
  Table table{{"law of", "kind", "AICc", "rms/sigma", "used", "parameters"}, {}};
  const auto add = [&](const char* what, const ident::IdentifiedCurve& curve, const std::string& unit) {
    for (const ident::LawFit& fit : curve.laws) {
      const fem::FrequencyLaw& law = fit.law;
      const bool used = &fit == &curve.laws.front();
      table.rows.push_back({what, fem::to_string(law.kind), fmt::format("{:.2f}", fit.aicc),
                            fmt::format("{:.2f}", fit.rms), used ? "yes" : "", ident::law_text(fit, unit)});
    }
  };
  add("modulus", identified.modulus, "Pa");
  add("loss factor", identified.loss_factor, "");
  return table;
}

void print_result(const ident::ModeSet& modes, const ident::IdentifiedParameters& identified) {
  print(trust_line(modes, identified));
  print("");
  print(modes_table(modes, identified));
  print("");
  if (!identified.rejected.empty()) {
    Table table{{"left out [Hz]", "of", "reason"}, {}};
    for (const ident::LeftOut& left_out : identified.rejected) {
      table.rows.push_back(
          {fmt::format("{:.3f}", left_out.frequency_hz), ident::to_string(left_out.what), left_out.reason});
    }
    print(table);
    print("");
  }
  print(laws_table(identified));
  print("");
  for (const std::string& line : fitted_lines(identified)) print(line);
  if (const std::string line = scene_error_line(identified); !line.empty()) print(line);
  print(rayleigh_line(identified));
  if (!identified.pairing.missing.empty()) {
    std::vector<int> missing = identified.pairing.missing;
    for (int& mode : missing) ++mode;
    print(fmt::format("model modes in the band that were not measured: {}", fmt::join(missing, ", ")));
  }
}

void run_fit(FitArguments& arguments) {
  const auto check_law = [](const char* option, const std::string& word) {
    if (!word.empty()) option_value(option, word, ident::fitted_law);
  };
  check_law("--modulus-law", arguments.options.modulus_law);
  check_law("--loss-factor-law", arguments.options.loss_factor_law);
  if (!arguments.band.empty()) {
    const Band band = parse_band(arguments.band);
    arguments.options.band_lo_hz = band.lo_hz;
    arguments.options.band_hi_hz = band.hi_hz;
  }
  if (!arguments.modulus_range.empty()) {
    const auto [lo, hi] = parse_modulus_range(arguments.modulus_range);
    arguments.options.pairing.modulus_lo = lo;
    arguments.options.pairing.modulus_hi = hi;
  }
  if (arguments.torsion_constant) arguments.options.free.push_back("torsion_constant");
  for (const std::string& name : arguments.options.free) option_value("--free", name, checked_number);
  fem::Scene scene = read_scene(arguments.scene);
  state_tolerance(scene, arguments.tolerance);
  blaming({arguments.scene}, [&] { fem::linear_path(scene); });
  const ident::ModeSet modes = ident::read_modes(arguments.modes);
  progress(fmt::format("pairing {} modes", modes.modes.size()));
  SceneFit found = blaming({arguments.modes, arguments.scene},
                           [&] { return fit_to_scene(scene, modes, arguments.options); });
  for (const ident::Doubt& doubt : found.doubts) warn(ident::sentence(doubt));
  for (const std::string& line : inseparable_lines(found.identified)) warn(line);
  ident::IdentifiedParameters& identified = found.identified;
  identified.provenance = provenance({arguments.scene, arguments.modes}, identified.provenance.band_lo_hz,
                                     identified.provenance.band_hi_hz);
  ident::write_parameters(identified, arguments.to, found.doubts);
  print_result(modes, identified);
  if (arguments.explain) {
    print("");
    print(explanation(fmt::format("sized for natural frequencies within {:g} up to {:g} Hz",
                                  found.request.tolerance, found.request.hi_hz),
                      fit_choices(found)));
  }
}

}  // namespace

void add_fit(CLI::App& app) {
  const auto arguments = std::make_shared<FitArguments>();
  CLI::App* const fit =
      app.add_subcommand("fit", "modulus, loss factor and Rayleigh coefficients from measured modes");
  fit->add_option("SCENE.toml", arguments->scene, "geometry, density, ends, drive and measurement")
      ->type_name("")
      ->required();
  fit->add_option("MODES.csv", arguments->modes, "modes, as `struna modes` writes them or made by hand")
      ->type_name("")
      ->required();
  fit->add_option("-o", arguments->to, "identified parameters to write")
      ->type_name(written_file + std::string(".toml"))
      ->required();
  const std::string laws = "constant, power, fractional_zener or monotone_spline; default: by AICc";
  fit->add_option("--modulus-law", arguments->options.modulus_law, laws)->type_name("WORD");
  fit->add_option("--loss-factor-law", arguments->options.loss_factor_law, laws)->type_name("WORD");
  fit->add_option("--band", arguments->band, "modes to use [Hz]; default: all")->type_name("LO:HI");
  fit->add_option("--modulus-range", arguments->modulus_range,
                  "where to look for the modulus [Pa]; default 1e6:1e12")
      ->type_name("LO:HI");
  fit->add_option("--free", arguments->options.free,
                  "numbers of the body to fit beside the modulus law (constant or power): torsion_constant, "
                  "start.rotation, end.rotation, both.rotation, the same with translation and mass")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  fit->add_flag("--torsion-constant", arguments->torsion_constant,
                "fits the torsion constant, which a curved body's modes tell: --free torsion_constant");
  fit->add_option("--tolerance", arguments->tolerance,
                  "of the model's natural frequencies, relative; default: the scene's, or 1e-5")
      ->type_name("NUMBER");
  fit->add_flag("--explain", arguments->explain,
                "tell what mesh was chosen, why, and what more or less would give");
  fit->footer(
      "Examples:\n"
      "  struna fit scene.toml modes.csv -o identified.toml\n"
      "  struna fit scene.toml modes.csv -o identified.toml --modulus-law power --band 10:900\n"
      "  struna fit scene.toml modes.csv -o identified.toml --modulus-law constant --free both.rotation");
  fit->callback([arguments] { run_fit(*arguments); });
}

}  // namespace struna::apps
