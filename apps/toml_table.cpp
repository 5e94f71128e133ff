#include "apps/toml_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>

namespace struna::apps {
namespace {

std::string type_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

/// A path as a file that names it means it: relative to that file's folder.
std::string beside(const std::string& file, const std::string& path) {
  return (std::filesystem::path(file).parent_path() / path).lexically_normal().string();
}

long line_of(const toml::node& node) {
  return static_cast<long>(node.source().begin.line);
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace

toml::table parse_toml(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) {
    throw Error(file, 0, "cannot be read; an existing, readable TOML file is needed");
  }
  try {
    return toml::parse(in, file);
  } catch (const toml::parse_error& fault) {
    throw Error(file, static_cast<long>(fault.source().begin.line),
                "is not valid TOML: " + std::string(fault.description()));
  }
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& words) {
  std::size_t best = std::max<std::size_t>(2, word.size() / 3) + 1;
  std::string nearest;
  for (const auto& candidate : words) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < std::min(best, candidate.size())) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

TomlTable::TomlTable(const toml::table& table, std::string file, std::string path)
    : table_(&table), file_(std::move(file)), path_(std::move(path)) {}

bool TomlTable::has(const std::string& key) {
  return node(key) != nullptr;
}

const toml::node* TomlTable::node(const std::string& key) {
  known_.insert(key);
  return table_->get(key);
}

const toml::node& TomlTable::required(const std::string& key) {
  const toml::node* found = node(key);
  if (found == nullptr) throw error(key, "is missing and must be given" + misspelling_of(key));
  return *found;
}

double TomlTable::number(const std::string& key) {
  const toml::node& found = required(key);
  if (!found.is_number()) throw error(key, "must be a number, got " + type_of(found));
  const double value = *found.value<double>();
  if (!std::isfinite(value)) throw error(key, fmt::format("must be a finite number, got {}", value));
  return value;
}

double TomlTable::number(const std::string& key, double fallback) {
  return has(key) ? number(key) : fallback;
}

double TomlTable::positive(const std::string& key) {
  const double value = number(key);
  if (value <= 0.0) throw error(key, fmt::format("must be > 0, got {}", value));
  return value;
}

double TomlTable::positive(const std::string& key, double fallback) {
  return has(key) ? positive(key) : fallback;
}

double TomlTable::not_negative(const std::string& key) {
  const double value = number(key);
  if (value < 0.0) throw error(key, fmt::format("must be >= 0, got {}", value));
  return value;
}

double TomlTable::not_negative(const std::string& key, double fallback) {
  return has(key) ? not_negative(key) : fallback;
}

std::string TomlTable::text(const std::string& key) {
  const toml::node& found = required(key);
  if (!found.is_string()) throw error(key, "must be text in quotes, got " + type_of(found));
  const std::string value = *found.value<std::string>();
  if (value.empty()) throw error(key, "must not be empty");
  return value;
}

std::string TomlTable::text(const std::string& key, const std::string& fallback) {
  return has(key) ? text(key) : fallback;
}

int TomlTable::integer(const std::string& key, int fallback) {
  const toml::node* found = node(key);
  if (found == nullptr) return fallback;
  if (!found->is_integer()) throw error(key, "must be an integer, got " + type_of(*found));
  const auto value = *found->value<std::int64_t>();
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
    throw error(key, fmt::format("is out of range, got {}", value));
  }
  return static_cast<int>(value);
}

bool TomlTable::flag(const std::string& key, bool fallback) {
  const toml::node* found = node(key);
  if (found == nullptr) return fallback;
  if (!found->is_boolean()) throw error(key, "must be true or false, got " + type_of(*found));
  return *found->value<bool>();
}

const toml::array& TomlTable::array(const std::string& key, const std::string& of) {
  const toml::node& found = required(key);
  if (!found.is_array()) throw error(key, "must be an array of " + of + ", got " + type_of(found));
  return *found.as_array();
}

std::vector<double> TomlTable::numbers(const std::string& key) {
  std::vector<double> values;
  for (const auto& element : array(key, "numbers")) {
    if (!element.is_number()) throw error(key, element, "must hold numbers only, got " + type_of(element));
    const double value = *element.value<double>();
    if (!std::isfinite(value))
      throw error(key, element, fmt::format("must hold finite numbers, got {}", value));
    values.push_back(value);
  }
  return values;
}

std::vector<std::string> TomlTable::texts(const std::string& key) {
  std::vector<std::string> values;
  for (const auto& element : array(key, "texts")) {
    if (!element.is_string())
      throw error(key, element, "must hold texts in quotes only, got " + type_of(element));
    values.push_back(*element.value<std::string>());
    if (values.back().empty()) throw error(key, element, "must not hold empty texts");
  }
  return values;
}

Eigen::Vector3d TomlTable::vector3(const std::string& key, const toml::node& node) const {
  const toml::array* parts = node.as_array();
  if (parts == nullptr || parts->size() != 3) {
    const std::string got = parts == nullptr ? type_of(node) : std::to_string(parts->size()) + " entries";
    throw error(key, node, "needs three numbers [x, y, z], got " + got);
  }
  Eigen::Vector3d value;
  for (int i = 0; i < 3; ++i) {
    const toml::node& part = (*parts)[static_cast<std::size_t>(i)];
    if (!part.is_number() || !std::isfinite(*part.value<double>())) {
      throw error(key, part,
                  "needs three finite numbers [x, y, z]" +
                      (part.is_number() ? std::string() : ", got " + type_of(part)));
    }
    value[i] = *part.value<double>();
  }
  return value;
}

Eigen::Vector3d TomlTable::vector3(const std::string& key) {
  return vector3(key, required(key));
}

std::vector<Eigen::Vector3d> TomlTable::vectors3(const std::string& key) {
  std::vector<Eigen::Vector3d> values;
  for (const auto& element : array(key, "points [x, y, z]")) values.push_back(vector3(key, element));
  return values;
}

TomlTable TomlTable::table(const std::string& key) {
  const toml::node& found = required(key);
  if (!found.is_table()) throw error(key, "must be a table, got " + type_of(found));
  return {*found.as_table(), file_, name(key)};
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) {
  std::vector<TomlTable> result;
  const toml::node* found = node(key);
  if (found == nullptr) return result;
  const toml::array* entries = found->as_array();
  if (entries == nullptr) {
    throw error(key,
                "must be written [[" + name(key) + "]], as there may be several, got " + type_of(*found));
  }
  for (const auto& entry : *entries) {
    if (!entry.is_table()) throw error(key, entry, "must hold tables only, got " + type_of(entry));
    result.emplace_back(*entry.as_table(), file_, name(key));
  }
  return result;
}

std::string TomlTable::path(const std::string& key) {
  return beside(file_, text(key));
}

std::vector<std::string> TomlTable::paths(const std::string& key) {
  std::vector<std::string> result = texts(key);
  for (auto& file : result) file = beside(file_, file);
  return result;
}

Band TomlTable::band(const std::string& key) {
  if (required(key).is_string()) {
    try {
      return parse_band(text(key));
    } catch (const Error& fault) {
      throw error(key, std::string("is no band: ") + fault.reason());
    }
  }
  const std::vector<double> ends = numbers(key);
  if (ends.size() != 2 || ends[0] < 0.0 || ends[0] >= ends[1]) {
    throw error(key, fmt::format("needs [lo, hi] in Hz with 0 <= lo < hi, got [{}]", fmt::join(ends, ", ")));
  }
  return {ends[0], ends[1]};
}

std::size_t TomlTable::index_of_word(const std::string& key, const std::vector<std::string>& words) {
  const std::string word = text(key);
  const auto found = std::find(words.begin(), words.end(), word);
  if (found == words.end())
    throw error(key, fmt::format("must be one of {}, got '{}'", fmt::join(words, ", "), word));
  return static_cast<std::size_t>(found - words.begin());
}

Eigen::Vector3d TomlTable::direction(const std::string& key, const toml::node& node) const {
  if (const auto word = node.value<std::string>()) {
    const std::string axes = "xyz";
    if (word->size() == 1 && axes.find(*word) != std::string::npos) {
      return Eigen::Vector3d::Unit(static_cast<int>(axes.find(*word)));
    }
    throw error(key, node, "must be \"x\", \"y\", \"z\" or a vector, got '" + *word + "'");
  }
  const Eigen::Vector3d vector = vector3(key, node);
  if (vector.norm() == 0.0) throw error(key, node, "must not be the zero vector");
  return vector.normalized();
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> result;
  for (const auto& [key, value] : *table_) result.emplace_back(key.str());
  return result;
}

std::string TomlTable::misspelling_of(const std::string& key) const {
  std::vector<std::string> unasked = keys();
  std::erase_if(unasked, [&](const std::string& word) { return known_.count(word) > 0; });
  const std::string nearest = nearest_word(key, unasked);
  return nearest.empty() ? "" : " (is that what '" + nearest + "' stands for?)";
}

void TomlTable::finish() const {
  // The first one in the file, so that the message does not depend on the alphabet.
  const toml::node* first = nullptr;
  std::string unknown;
  for (const auto& [key, value] : *table_) {
    if (known_.count(std::string(key.str())) > 0) continue;
    if (first == nullptr || line_of(value) < line_of(*first)) {
      first = &value;
      unknown = key.str();
    }
  }
  if (first == nullptr) return;
  const std::vector<std::string> words(known_.begin(), known_.end());
  const std::string nearest = nearest_word(unknown, words);
  throw error(unknown, "is not a known key; " + (nearest.empty()
                                                     ? fmt::format("known here: {}", fmt::join(words, ", "))
                                                     : "did you mean '" + nearest + "'?"));
}

std::string TomlTable::name(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

long TomlTable::line() const {
  return path_.empty() ? 0 : line_of(*table_);
}

Error TomlTable::error(const std::string& key, const std::string& message) const {
  const toml::node* found = table_->get(key);
  return {file_, found != nullptr ? line_of(*found) : line(), name(key) + " " + message};
}

Error TomlTable::error(const std::string& key, const toml::node& at, const std::string& message) const {
  return {file_, line_of(at), name(key) + " " + message};
}

std::string TomlTable::place() const {
  return fmt::format("{}:{}", file_, line());
}

Error TomlTable::error(const std::string& message) const {
  return {file_, line(), (path_.empty() ? "" : path_ + ": ") + message};
}

}  // namespace struna::apps
