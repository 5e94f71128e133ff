#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/error.hpp"
#include "ident/parameter_file.hpp"

namespace struna::ident {
namespace {

using fem::FrequencyLaw;

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

/// n x n numbers, row by row, as the key has them: symmetric, without negative variances.
Eigen::MatrixXd read_covariance(const Reader& reader, Eigen::Index n) {
  const Eigen::VectorXd numbers = vector(reader.numbers("covariance"));
  const auto refuse = [&](const std::string& what) {
    reader.refuse(&reader.node("covariance"),
                  fmt::format("{}.covariance: {} x {} numbers, row by row, {}", reader.path(), n, n, what));
  };
  if (numbers.size() != n * n) refuse(fmt::format("got {}", numbers.size()));
  const Eigen::MatrixXd covariance = numbers.reshaped(n, n);
  if (!covariance.allFinite()) refuse("all finite");
  const Eigen::VectorXd variance = covariance.diagonal();
  if (!(variance.array() >= 0.0).all())
    refuse(fmt::format("variances of zero or more, got {:g}", variance.minCoeff()));
  // Correlations, as parameters differ by orders of magnitude; digits of a file leave little of a -1.
  const Eigen::VectorXd scale =
      variance.unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 0.0; });
  const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  constexpr double rounding = 1e-6;
  if (!correlation.isApprox(correlation.transpose(), rounding))
    refuse("the same above and below the diagonal");
  if (n > 0 && correlation.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() < -rounding)
    refuse("which no numbers can have: some combination of them has a negative variance");
  return covariance;
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
  if (reader.has("covariance"))
    fit.covariance =
        read_covariance(reader, static_cast<Eigen::Index>(law.parameters.size() + law.value.size()));
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
    for (const auto& [key, sigma] : {std::pair{"sigma", &curve.sigma},
                                     {"scene_sigma", &curve.scene_sigma},
                                     {"fitted_sigma", &curve.fitted_sigma}}) {
      if (reader.has(key) && (sigma->array() < 0.0).any())
        reader.refuse(&reader.node(key), fmt::format("[{}] {} must not be negative", reader.path(), key));
      if (reader.has(key) && sigma->size() != n && sigma != &curve.sigma)
        reader.refuse(&reader.node(key),
                      fmt::format("[{}] frequency and {} must have equal length, got {} and {}",
                                  reader.path(), key, n, sigma->size()));
    }
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
  reader.only({"alpha", "beta", "alpha_sigma", "beta_sigma", "covariance", "rms", "misfit", "chance",
               "determined", "flag"});
  RayleighFit fit;
  fit.rayleigh = {reader.number("alpha"), reader.number("beta")};
  for (const char* key : {"alpha", "beta"}) {
    const double value = reader.number(key);
    if (!(value >= 0.0) || !std::isfinite(value)) {
      reader.refuse(&reader.node(key),
                    fmt::format("rayleigh.{} must be zero or positive, got {}", key, value));
    }
  }
  for (const char* key : {"alpha_sigma", "beta_sigma"})
    if (reader.has(key) && !(reader.number(key) >= 0.0))
      reader.refuse(&reader.node(key), fmt::format("rayleigh.{} must not be negative", key));
  fit.alpha_sigma = reader.number("alpha_sigma", 0.0);
  fit.beta_sigma = reader.number("beta_sigma", 0.0);
  fit.covariance = reader.number("covariance", 0.0);
  fit.rms = reader.number("rms", std::numeric_limits<double>::quiet_NaN());  // none: written by hand
  fit.misfit = reader.number("misfit", 0.0);
  fit.chance = reader.number("chance", 1.0);
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
  if (fitted.value.size() != n)
    reader.refuse(&reader.node("value"), fmt::format("[fitted]: {} values, got {}", n, fitted.value.size()));
  if (!(fitted.value.array() >= 0.0).all() || !fitted.value.allFinite())
    reader.refuse(&reader.node("value"), "fitted.value must be zero or positive");
  fitted.covariance = reader.has("covariance") ? read_covariance(reader, n) : Eigen::MatrixXd::Zero(n, n);
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
