#include "apps/study_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "apps/toml_table.hpp"

namespace struna::apps {
namespace {

/// The value of a key by one of the library's word readers, whose Error gets the key's file and line.
template <class Reader>
auto word(TomlTable& table, const std::string& key, Reader read) {
  const std::string text = table.text(key);
  try {
    return read(text);
  } catch (const Error& fault) {
    throw table.error(key, std::string("is not understood: ") + fault.reason());
  }
}

void check_frequencies(const TomlTable& table, const std::string& key, const std::vector<double>& values) {
  for (const double value : values) {
    if (value <= 0.0) throw table.error(key, fmt::format("must hold frequencies above 0 Hz, got {}", value));
  }
}

TransferSettings read_transfer(TomlTable table) {
  TransferSettings settings;
  ident::WelchOptions& welch = settings.welch;
  welch.resolution_hz = table.positive("resolution", welch.resolution_hz);
  welch.overlap = table.not_negative("overlap", welch.overlap);
  if (welch.overlap > 0.9) {
    throw table.error("overlap", fmt::format("must be a fraction from 0 to 0.9, got {}", welch.overlap));
  }
  if (table.has("window")) welch.window = word(table, "window", ident::window_kind);
  if (table.has("exponential_end") && welch.window != ident::Window::exponential) {
    throw table.error("exponential_end", "goes with window = \"exponential\"");
  }
  welch.exponential_end = table.positive("exponential_end", welch.exponential_end);
  if (welch.exponential_end >= 1.0) {
    throw table.error("exponential_end", fmt::format("must be below 1, got {}", welch.exponential_end));
  }
  welch.impact = table.flag("impact", welch.impact);
  if (table.has("estimator")) {
    const ident::EstimatorWord chosen = word(table, "estimator", ident::estimator_word);
    settings.method = chosen.method;
    settings.estimator = chosen.ratio;
  }
  if (table.has("fixture")) settings.fixture = table.path("fixture");
  if (table.has("clamp_mass")) {
    TomlTable masses = table.table("clamp_mass");
    for (const std::string& name : masses.keys()) settings.clamp_mass[name] = masses.not_negative(name, 0.0);
  }
  if (table.has("drive_signal")) settings.drive_signal = table.text("drive_signal");
  if (table.has("form") && table.text("form") != "as-measured")
    settings.form = word(table, "form", ident::frf_kind);
  if (table.has("band")) settings.band = table.band("band");
  table.finish();
  return settings;
}

ident::ModeOptions read_modes_options(TomlTable table) {
  ident::ModeOptions options;
  if (table.has("method")) options.method = word(table, "method", ident::mode_method);
  if (table.has("damping")) options.damping = word(table, "damping", fem::damping_kind);
  if (table.has("band")) {
    const Band band = table.band("band");
    options.band_lo_hz = band.lo_hz;
    options.band_hi_hz = band.hi_hz;
  }
  if (table.has("frequencies")) options.frequencies_hz = table.numbers("frequencies");
  check_frequencies(table, "frequencies", options.frequencies_hz);
  if (table.has("add")) options.extra_hz = table.numbers("add");
  check_frequencies(table, "add", options.extra_hz);
  if (!options.frequencies_hz.empty() && !options.extra_hz.empty()) {
    throw table.error("add", "contradicts frequencies: those only, or these besides the ones found");
  }
  table.finish();
  return options;
}

std::string read_law_name(TomlTable& table, const std::string& key) {
  return table.choice<std::string>(key,
                                   {{"constant", "constant"},
                                    {"power", "power"},
                                    {"fractional_zener", "fractional_zener"},
                                    {"monotone_spline", "monotone_spline"}},
                                   "");
}

ident::FitOptions read_fit_options(TomlTable table) {
  ident::FitOptions options;
  options.modulus_law = read_law_name(table, "modulus_law");
  options.loss_factor_law = read_law_name(table, "loss_factor_law");
  if (table.has("band")) {
    const Band band = table.band("band");
    options.band_lo_hz = band.lo_hz;
    options.band_hi_hz = band.hi_hz;
  }
  if (table.has("free")) {
    options.free = table.texts("free");
    const std::vector<std::string> known = fem::fittable_numbers();
    for (const std::string& name : options.free) {
      if (std::find(known.begin(), known.end(), name) == known.end()) {
        throw table.error("free", fmt::format("must be of {}, got '{}'", fmt::join(known, ", "), name));
      }
    }
  }
  if (table.has("modulus_range")) {
    const auto range = table.numbers("modulus_range");
    if (range.size() != 2 || range[0] <= 0.0 || range[0] >= range[1]) {
      throw table.error("modulus_range", fmt::format("needs [lo, hi] in Pa with 0 < lo < hi, got [{}]",
                                                     fmt::join(range, ", ")));
    }
    options.pairing.modulus_lo = range[0];
    options.pairing.modulus_hi = range[1];
  }
  table.finish();
  return options;
}

ident::ChannelCorrection read_correction(TomlTable table) {
  ident::ChannelCorrection correction;
  correction.sensitivity = table.number("sensitivity", correction.sensitivity);
  if (correction.sensitivity == 0.0) throw table.error("sensitivity", "must not be zero");
  correction.sign = table.number("sign", correction.sign);
  if (correction.sign != 1.0 && correction.sign != -1.0) {
    throw table.error("sign", fmt::format("must be 1 or -1, got {}", correction.sign));
  }
  correction.delay = table.number("delay", correction.delay);
  correction.unit = table.text("unit", "");
  if (!correction.unit.empty()) word(table, "unit", ident::parse_unit);
  table.finish();
  return correction;
}

std::map<std::string, ident::ChannelCorrection> read_corrections(TomlTable table, const Study& study) {
  std::map<std::string, ident::ChannelCorrection> corrections;
  for (const auto& name : table.keys()) {
    const bool input = std::any_of(study.references.begin(), study.references.end(),
                                   [&](const auto& reference) { return reference.input == name; });
    if (!input && std::count(study.outputs.begin(), study.outputs.end(), name) == 0) {
      throw table.error(name, "corrects a column that is neither the input nor an output");
    }
    corrections[name] = read_correction(table.table(name));
  }
  return corrections;
}

StudyReference read_reference(TomlTable table, const std::string& input) {
  StudyReference reference;
  reference.records = table.paths("records");
  if (reference.records.empty()) throw table.error("records", "must name at least one file");
  reference.input = table.text("input", input);
  if (reference.input.empty()) throw table.error("needs an input, here or for the whole study");
  const toml::node& direction = table.required("direction");
  reference.direction = table.direction("direction", direction);
  reference.name = table.text("name", direction.value_or(std::string()));
  if (reference.name.empty())
    throw table.error("name", "is needed where the direction is a vector, such as name = \"diagonal\"");
  table.finish();
  return reference;
}

std::vector<StudyReference> read_references(TomlTable& root) {
  if (!root.has("reference")) {
    std::vector<std::string> records = root.paths("records");
    return {{"", std::nullopt, root.text("input"), std::move(records)}};
  }
  if (root.has("records"))
    throw root.error("records", "contradicts [[reference]]: each reference has its own records");
  std::vector<StudyReference> references;
  const std::string input = root.text("input", "");
  for (TomlTable& table : root.tables("reference")) references.push_back(read_reference(table, input));
  return references;
}

void check_channels(const TomlTable& root, const Study& study) {
  if (study.outputs.empty()) throw root.error("outputs", "must name at least one column");
  for (const StudyReference& reference : study.references) {
    if (reference.records.empty()) throw root.error("records", "must name at least one file");
    if (std::count(study.outputs.begin(), study.outputs.end(), reference.input) > 0)
      throw root.error("outputs", "must not hold the input '" + reference.input + "'");
  }
  for (const auto& output : study.outputs) {
    if (std::count(study.outputs.begin(), study.outputs.end(), output) > 1) {
      throw root.error("outputs", "names '" + output + "' a second time");
    }
  }
}

}  // namespace

Study read_study(const std::string& file) {
  const toml::table content = parse_toml(file);
  TomlTable root(content, file);
  Study study;
  study.file = file;
  study.scene = root.path("scene");
  study.references = read_references(root);
  for (const auto& reference : study.references)
    study.records.insert(study.records.end(), reference.records.begin(), reference.records.end());
  if (study.references.empty()) throw root.error("reference", "must hold at least one table");
  study.input = study.references.front().input;
  study.outputs = root.texts("outputs");
  check_channels(root, study);
  if (root.has("channel")) study.corrections = read_corrections(root.table("channel"), study);
  if (root.has("transfer")) study.transfer = read_transfer(root.table("transfer"));
  if (root.has("modes")) study.modes = read_modes_options(root.table("modes"));
  if (root.has("fit")) study.fit = read_fit_options(root.table("fit"));
  if (root.has("compare")) {
    TomlTable compare = root.table("compare");
    if (compare.has("band")) study.compare = compare.band("band");
    compare.finish();
  }
  root.finish();
  return study;
}

}  // namespace struna::apps
