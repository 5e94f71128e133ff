#include "ident/parameter_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "fem/error.hpp"
#include "ident/atomic_file.hpp"
#include "ident/rayleigh_flag.hpp"

namespace struna::ident {
namespace {

using fem::FrequencyLaw;
using Kind = FrequencyLaw::Kind;

/// Names of a law's parameters in the file, in the order of FrequencyLaw::parameters.
std::vector<std::string> parameter_names(Kind kind) {
  switch (kind) {
    case Kind::constant:
      return {"value"};
    case Kind::power:
      return {"value", "exponent", "reference_frequency"};
    case Kind::fractional_zener:
      return {"value", "ratio", "relaxation_frequency", "order"};
    case Kind::monotone_spline:
    case Kind::table:
      break;
  }
  return {};
}

// ---- writing

/// The shortest digits that read back as the same double, marked as a TOML float.
std::string number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

template <class Values>
std::string array(const Values& values) {
  std::vector<std::string> texts;
  for (double value : values) texts.push_back(number(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

std::string law_lines(const LawFit& fit) {
  const FrequencyLaw& law = fit.law;
  std::string text = fmt::format("kind = \"{}\"\n", fem::to_string(law.kind));
  const std::vector<std::string> names = parameter_names(law.kind);
  for (std::size_t k = 0; k < names.size(); ++k) {
    text += fmt::format("{} = {}\n", names[k], number(law.parameters[k]));
  }
  if (names.empty()) {
    text += fmt::format("frequency = {}\nvalue = {}\n", array(law.frequency), array(law.value));
  }
  text += fmt::format("parameter_sigma = {}  # standard errors, in the order above\n",
                      array(fit.parameter_sigma));
  if (fit.covariance.size() > 0)
    text += fmt::format("covariance = {}  # of the same, row by row\n", array(fit.covariance.reshaped()));
  if (law.valid_to_hz > 0.0) {
    text += fmt::format("valid_from = {}  # Hz, the data's range\nvalid_to = {}\n", number(law.valid_from_hz),
                        number(law.valid_to_hz));
  }
  return text + fmt::format("aicc = {}\nrms = {}\n", number(fit.aicc), number(fit.rms));
}

std::string curve_lines(const std::string& name, const IdentifiedCurve& curve, const std::string& unit,
                        const std::string& extra) {
  std::string text = fmt::format("[{}]\nfrequency = {}  # Hz, measured natural frequencies\n", name,
                                 array(curve.frequency_hz));
  text += fmt::format("value = {}{}\nsigma = {}  # with the model's own error\n", array(curve.value), unit,
                      array(curve.sigma));
  if (curve.scene_sigma.size() > 0)
    text += fmt::format("scene_sigma = {}  # of what the scene states, besides; common to all\n",
                        array(curve.scene_sigma));
  if (curve.fitted_sigma.size() > 0)
    text += fmt::format("fitted_sigma = {}  # of what was fitted of the body, besides; common to all\n",
                        array(curve.fitted_sigma));
  text += extra;
  for (std::size_t k = 0; k < curve.laws.size(); ++k) {
    text += k == 0 ? fmt::format("\n[{}.law]  # what predictions use\n", name)
                   : fmt::format("\n[[{}.other_law]]\n", name);
    text += law_lines(curve.laws[k]);
  }
  return text + "\n";
}

std::string rayleigh_lines(const RayleighFit& fit) {
  return fmt::format(
      "[rayleigh]\nalpha = {}  # 1/s\nbeta = {}  # s\nalpha_sigma = {}\nbeta_sigma = {}\ncovariance = {}\n"
      "rms = {}\nmisfit = {}\ndetermined = {}\nflag = \"{}\"\n\n",
      number(fit.rayleigh.alpha), number(fit.rayleigh.beta), number(fit.alpha_sigma), number(fit.beta_sigma),
      number(fit.covariance), number(fit.rms), number(fit.misfit), fit.determined,
      to_string(rayleigh_flag(fit)));
}

template <class Texts>
std::string text_array(const Texts& texts) {
  std::vector<std::string> words;
  for (const std::string& text : texts) words.push_back(quoted(text));
  return fmt::format("[{}]", fmt::join(words, ", "));
}

std::string fitted_lines(const FittedNumbers& fitted) {
  std::string text;
  if (!fitted.name.empty()) {
    text += fmt::format(
        "[fitted]  # numbers of the body, beside the modulus; they replace the scene's\nnumber = {}\nvalue = "
        "{}\n"
        "sigma = {}\ncovariance = {}  # relative but for masses, row by row\ncondition = {}\n\n",
        text_array(fitted.name), array(fitted.value), array(fitted.sigma()),
        array(fitted.covariance.reshaped()), number(fitted.condition));
  }
  for (const FittedNumbers::Inseparable& left : fitted.inseparable) {
    text += fmt::format(
        "[[inseparable]]  # asked for, and left as the scene has it\nnumber = {}\nreason = {}\n\n",
        quoted(left.name), quoted(left.reason));
  }
  return text;
}

std::string error_lines(const std::vector<BodyErrorStep>& errors) {
  std::string text;
  for (const BodyErrorStep& step : errors) {
    text += fmt::format(
        "[[body_error]]  # one independent error of one sigma, and what follows from it\nof = {}\n",
        quoted(step.of));
    if (!step.is_fitted())
      text += fmt::format("value = {}\nsigma = {}\n", number(step.value), number(step.sigma));
    text += fmt::format(
        "level = {}  # relative, of the modulus\nlaw_step = {}  # of the law's numbers\nnumber = {}\n"
        "change = {}\n\n",
        number(step.level), array(step.law_step), text_array(step.number), array(step.change));
  }
  return text;
}

std::string pair_lines(const Pairing& pairing) {
  std::string text;
  for (const Pair& pair : pairing.pairs) {
    std::vector<int> model = pair.model;
    for (int& mode : model) ++mode;
    text += fmt::format(
        "[[pair]]\nmode = {}\nmodel = [{}]\nmac = {}\nmodulus = {}\nmodulus_sigma = {}  # noise alone\n\n",
        pair.measured + 1, fmt::join(model, ", "), number(pair.mac), number(pair.modulus),
        number(pair.modulus_sigma));
  }
  return text;
}

std::string doubt_lines(const std::vector<Doubt>& doubts) {
  std::string text;
  for (const Doubt& doubt : doubts) {
    text += fmt::format("[[doubt]]\nkind = \"{}\"\ntext = {}\n\n", to_string(doubt.kind),
                        quoted(sentence(doubt)));
  }
  return text;
}

std::string provenance_lines(const Provenance& provenance) {
  std::string text =
      fmt::format("[provenance]\nprogram = \"struna\"\nversion = {}\ndate = {}\nband = [{}, {}]  # Hz\n",
                  quoted(provenance.program_version), quoted(provenance.date), number(provenance.band_lo_hz),
                  number(provenance.band_hi_hz));
  for (const auto& [file, checksum] : provenance.inputs) {
    text += fmt::format("\n[[provenance.input]]\nfile = {}\nsha256 = {}\n", quoted(file), quoted(checksum));
  }
  return text;
}

// ---- reading

/// One table of the file, its keys asked for by name.
class Reader {
 public:
  Reader(const std::string& file, const toml::table& table, std::string path)
      : file_(file), table_(table), path_(std::move(path)) {}

  bool has(const char* key) const { return table_.contains(key); }

  [[noreturn]] void refuse(const toml::node* at, const std::string& message) const {
    throw Error(file_, at != nullptr ? at->source().begin.line : table_.source().begin.line, message);
  }
  const toml::node& node(const char* key) const {
    const toml::node* found = table_.get(key);
    if (found == nullptr) refuse(nullptr, fmt::format("{} has no {}; add it", path_, key));
    return *found;
  }
  std::string text(const char* key) const {
    const toml::node& found = node(key);
    if (!found.is_string()) refuse(&found, fmt::format("{}.{} must be text", path_, key));
    return *found.value<std::string>();
  }
  double number(const char* key) const { return number(node(key), key); }
  double number(const char* key, double fallback) const { return has(key) ? number(key) : fallback; }
  std::vector<double> numbers(const char* key) const {
    const toml::node& found = node(key);
    if (!found.is_array()) refuse(&found, fmt::format("{}.{} must be an array of numbers", path_, key));
    std::vector<double> values;
    for (const toml::node& element : *found.as_array()) values.push_back(number(element, key));
    return values;
  }
  std::vector<std::string> texts(const char* key) const {
    const toml::node& found = node(key);
    std::vector<std::string> values;
    if (found.is_array()) {
      for (const toml::node& element : *found.as_array()) {
        if (element.is_string()) values.push_back(*element.value<std::string>());
      }
    }
    if (!found.is_array() || values.size() != found.as_array()->size())
      refuse(&found, fmt::format("{}.{} must be an array of texts", path_, key));
    return values;
  }
  std::vector<Reader> tables(const char* key) const {
    std::vector<Reader> all;
    if (!has(key)) return all;
    const toml::node& found = node(key);
    if (!found.is_array_of_tables()) refuse(&found, fmt::format("{} must be tables, [[{}]]", key, key));
    for (const toml::node& element : *found.as_array()) all.emplace_back(file_, *element.as_table(), key);
    return all;
  }
  Reader table(const char* key) const {
    const toml::node& found = node(key);
    if (!found.is_table()) refuse(&found, fmt::format("{}.{} must be a table", path_, key));
    return Reader(file_, *found.as_table(), path_.empty() ? key : path_ + "." + key);
  }
  /// Refuses keys that are not in the list: a misspelt one would be passed over otherwise.
  void only(const std::vector<std::string>& known) const {
    for (const auto& [key, value] : table_) {
      const std::string name(key.str());
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      refuse(&value, fmt::format("unknown key \"{}\"{}; known are {}", name,
                                 path_.empty() ? "" : " in [" + path_ + "]", fmt::join(known, ", ")));
    }
  }
  const std::string& path() const { return path_; }

 private:
  double number(const toml::node& found, const char* key) const {
    if (!found.is_number()) refuse(&found, fmt::format("{}.{} must be a number", path_, key));
    return *found.value<double>();
  }

  const std::string& file_;
  const toml::table& table_;
  std::string path_;
};

Eigen::VectorXd vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Eigen::MatrixXd read_covariance(const Reader& reader, const FrequencyLaw& law) {
  const Eigen::VectorXd numbers = vector(reader.numbers("covariance"));
  const auto n = static_cast<Eigen::Index>(law.parameters.size() + law.value.size());
  if (numbers.size() != n * n)
    reader.refuse(&reader.node("covariance"),
                  fmt::format("{}.covariance: {} x {} numbers, row by row, got {}", reader.path(), n, n,
                              numbers.size()));
  return numbers.reshaped(n, n);  // symmetric: rows are columns
}

LawFit read_law(const Reader& reader, bool allow_zero) {
  LawFit fit;
  FrequencyLaw& law = fit.law;
  const std::string kind = reader.text("kind");
  try {
    law.kind = fem::law_kind(kind);
  } catch (const Error& error) {
    reader.refuse(&reader.node("kind"), fmt::format("{}.kind: {}", reader.path(), error.reason()));
  }
  std::vector<std::string> known = parameter_names(law.kind);
  if (known.empty()) {
    known = {"frequency", "value"};
    law.frequency = reader.numbers("frequency");
    law.value = reader.numbers("value");
  } else {
    for (const std::string& name : known) law.parameters.push_back(reader.number(name.c_str()));
  }
  known.insert(known.end(),
               {"kind", "valid_from", "valid_to", "parameter_sigma", "covariance", "aicc", "rms"});
  reader.only(known);
  law.valid_from_hz = reader.number("valid_from", 0.0);
  law.valid_to_hz = reader.number("valid_to", 0.0);
  fit.aicc = reader.number("aicc", 0.0);
  fit.rms = reader.number("rms", 0.0);
  if (reader.has("parameter_sigma")) fit.parameter_sigma = vector(reader.numbers("parameter_sigma"));
  if (reader.has("covariance")) fit.covariance = read_covariance(reader, law);
  try {
    fem::validate(law, reader.path(), allow_zero);
  } catch (const Error& error) {
    reader.refuse(nullptr, error.what());
  }
  return fit;
}

IdentifiedCurve read_curve(const Reader& reader, bool allow_zero) {
  reader.only(
      {"frequency", "value", "sigma", "scene_sigma", "fitted_sigma", "kramers_kronig", "law", "other_law"});
  IdentifiedCurve curve;
  if (reader.has("frequency") || reader.has("value")) {
    curve.frequency_hz = vector(reader.numbers("frequency"));
    curve.value = vector(reader.numbers("value"));
    if (reader.has("sigma")) curve.sigma = vector(reader.numbers("sigma"));
    if (reader.has("scene_sigma")) curve.scene_sigma = vector(reader.numbers("scene_sigma"));
    if (reader.has("fitted_sigma")) curve.fitted_sigma = vector(reader.numbers("fitted_sigma"));
    const Eigen::Index n = curve.frequency_hz.size();
    if (curve.value.size() != n || (reader.has("sigma") && curve.sigma.size() != n)) {
      reader.refuse(
          &reader.node("value"),
          fmt::format("frequency, value and sigma of [{}] must have equal length, got {}, {} and {}",
                      reader.path(), n, curve.value.size(), curve.sigma.size()));
    }
  }
  if (!reader.has("law")) {
    if (curve.value.size() == 0) return curve;
    reader.refuse(
        nullptr,
        fmt::format("[{0}] has no law for predictions; add [{0}.law], for instance with kind = \"table\"",
                    reader.path()));
  }
  curve.laws.push_back(read_law(reader.table("law"), allow_zero));
  for (const Reader& other : reader.tables("other_law")) curve.laws.push_back(read_law(other, allow_zero));
  return curve;
}

RayleighFit read_rayleigh(const Reader& reader) {
  reader.only(
      {"alpha", "beta", "alpha_sigma", "beta_sigma", "covariance", "rms", "misfit", "determined", "flag"});
  RayleighFit fit;
  fit.rayleigh = {reader.number("alpha"), reader.number("beta")};
  for (const char* key : {"alpha", "beta"}) {
    const double value = reader.number(key);
    if (!(value >= 0.0) || !std::isfinite(value)) {
      reader.refuse(&reader.node(key),
                    fmt::format("rayleigh.{} must be zero or positive, got {}", key, value));
    }
  }
  fit.alpha_sigma = reader.number("alpha_sigma", 0.0);
  fit.beta_sigma = reader.number("beta_sigma", 0.0);
  fit.covariance = reader.number("covariance", 0.0);
  fit.rms = reader.number("rms", 0.0);
  fit.misfit = reader.number("misfit", 0.0);
  fit.determined = true;
  if (reader.has("determined")) {
    const toml::node& node = reader.node("determined");
    if (!node.is_boolean()) reader.refuse(&node, "rayleigh.determined must be true or false");
    fit.determined = *node.value<bool>();
  }
  return fit;
}

FittedNumbers read_fitted(const Reader& reader) {
  reader.only({"number", "value", "sigma", "covariance", "condition"});
  FittedNumbers fitted;
  fitted.name = reader.texts("number");
  fitted.value = vector(reader.numbers("value"));
  fitted.condition = reader.number("condition", 0.0);
  const auto n = static_cast<Eigen::Index>(fitted.name.size());
  const std::vector<std::string> known = fem::fittable_numbers();
  for (const std::string& name : fitted.name) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      reader.refuse(&reader.node("number"),
                    fmt::format("fitted.number: {}, got \"{}\"", fmt::join(known, ", "), name));
  }
  Eigen::VectorXd covariance = Eigen::VectorXd::Zero(n * n);
  if (reader.has("covariance")) covariance = vector(reader.numbers("covariance"));
  if (fitted.value.size() != n || covariance.size() != n * n) {
    reader.refuse(
        &reader.node("value"),
        fmt::format("[fitted]: {0} values and {0} x {0} numbers of covariance, row by row, got {1} and {2}",
                    n, fitted.value.size(), covariance.size()));
  }
  if (!(fitted.value.array() >= 0.0).all() || !fitted.value.allFinite())
    reader.refuse(&reader.node("value"), "fitted.value must be zero or positive");
  fitted.covariance = covariance.reshaped(n, n);  // symmetric: rows are columns
  return fitted;
}

BodyErrorStep read_error(const Reader& reader, const IdentifiedCurve& modulus) {
  reader.only({"of", "value", "sigma", "level", "law_step", "number", "change"});
  BodyErrorStep step;
  step.of = reader.text("of");
  if (!step.is_fitted()) {
    step.value = reader.number("value");
    step.sigma = reader.number("sigma");
  }
  step.level = reader.number("level", 0.0);
  step.law_step = vector(reader.numbers("law_step"));
  step.number = reader.texts("number");
  step.change = reader.numbers("change");
  const std::size_t numbers = modulus.laws.empty() ? 0
                                                   : modulus.laws.front().law.parameters.size() +
                                                         modulus.laws.front().law.value.size();
  if (step.number.size() != step.change.size() || (step.number.empty() && !step.is_fitted()))
    reader.refuse(&reader.node("change"), "body_error: number and change must have equal length");
  if (static_cast<std::size_t>(step.law_step.size()) != numbers)
    reader.refuse(&reader.node("law_step"),
                  fmt::format("body_error.law_step: a number for each of the modulus law's {}, got {}",
                              numbers, step.law_step.size()));
  return step;
}

toml::table parse(const std::string& file) {
  try {
    return toml::parse_file(file);
  } catch (const toml::parse_error& error) {
    throw Error(file, error.source().begin.line, std::string(error.description()));
  }
}

}  // namespace

std::string law_text(const LawFit& fit, const std::string& unit) {
  const FrequencyLaw& law = fit.law;
  const auto with_unit = [](double value, const std::string& of) {
    return fmt::format("{:.5g}{}{}", value, of.empty() ? "" : " ", of);
  };
  std::vector<std::string> parts;
  const std::vector<std::string> names = parameter_names(law.kind);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const bool frequency = names[k].find("frequency") != std::string::npos;
    const std::string& of = frequency ? "Hz" : names[k] == "value" ? unit : "";
    const auto at = static_cast<Eigen::Index>(k);
    const bool known = at < fit.parameter_sigma.size() && fit.parameter_sigma[at] > 0.0;
    const std::string error = known ? fmt::format(" +- {:.2g}", fit.parameter_sigma[at]) : "";
    parts.push_back(
        fmt::format("{} {:.5g}{}{}{}", names[k], law.parameters[k], error, of.empty() ? "" : " ", of));
  }
  for (std::size_t k = 0; k < law.value.size(); ++k) {
    parts.push_back(with_unit(law.value[k], unit) + " at " + with_unit(law.frequency[k], "Hz"));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void write_parameters(const IdentifiedParameters& identified, const std::string& file,
                      const std::vector<Doubt>& doubts) {
  std::string text = fmt::format("body = {}  # these override its material, and no other body's\n\n",
                                 quoted(identified.body));
  if (!doubts.empty()) text += "# This result is doubted: see [[doubt]] below.\n\n";
  if (identified.rayleigh_known) text += rayleigh_lines(identified.rayleigh);
  text += curve_lines("modulus", identified.modulus, "  # Pa", "");
  if (identified.loss_factor.value.size() > 0 || !identified.loss_factor.laws.empty()) {
    text += curve_lines("loss_factor", identified.loss_factor, "",
                        fmt::format("kramers_kronig = {}  # (pi/2) d ln E/d ln f, for information\n",
                                    array(identified.kramers_kronig_loss_factor)));
  }
  text += fitted_lines(identified.fitted);
  text += error_lines(identified.errors);
  text += pair_lines(identified.pairing);
  for (const LeftOut& left_out : identified.rejected) {
    text += fmt::format("[[rejected]]\nfrequency = {}\nof = \"{}\"\nreason = {}\n\n",
                        number(left_out.frequency_hz), to_string(left_out.what), quoted(left_out.reason));
  }
  text += doubt_lines(doubts);
  text += provenance_lines(identified.provenance);
  write_atomically(file, text);
}

IdentifiedParameters read_parameters(const std::string& file) {
  const toml::table root = parse(file);
  const Reader reader(file, root, "");
  reader.only({"body", "rayleigh", "modulus", "loss_factor", "fitted", "inseparable", "body_error", "pair",
               "rejected", "doubt", "provenance"});
  IdentifiedParameters identified;
  if (!reader.has("body"))
    throw Error(file, 0, "has no body; add body = \"NAME\", the body that the parameters belong to");
  identified.body = reader.text("body");
  if (reader.has("rayleigh")) {
    identified.rayleigh = read_rayleigh(reader.table("rayleigh"));
    identified.rayleigh_known = true;
  }
  if (reader.has("modulus")) identified.modulus = read_curve(reader.table("modulus"), false);
  if (reader.has("loss_factor")) identified.loss_factor = read_curve(reader.table("loss_factor"), true);
  if (reader.has("fitted")) identified.fitted = read_fitted(reader.table("fitted"));
  for (const Reader& error : reader.tables("body_error"))
    identified.errors.push_back(read_error(error, identified.modulus));
  if (!identified.rayleigh_known && identified.modulus.laws.empty() && identified.loss_factor.laws.empty()) {
    throw Error(file, 0, "has no parameters; add [modulus.law], [loss_factor.law] or [rayleigh]");
  }
  return identified;
}

}  // namespace struna::ident
