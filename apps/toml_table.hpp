#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "apps/usage.hpp"

namespace struna::apps {

/// Parses a TOML file; a syntax error becomes an Error with file and line.
toml::table parse_toml(const std::string& file);

/// The one of `words` that `word` is probably a misspelling of; "" when none is near (Levenshtein distance).
std::string nearest_word(const std::string& word, const std::vector<std::string>& words);

/// A table read key by key. Typed getters throw Error with file and line; finish() refuses keys that nobody
/// asked for (with the nearest known one as a hint). Numbers are finite, integers serve as numbers. Refers to
/// the toml::table, which must outlive it.
class TomlTable {
 public:
  TomlTable(const toml::table& table, std::string file, std::string path = "");

  bool has(const std::string& key);  ///< marks the key as known
  double number(const std::string& key);
  double number(const std::string& key, double fallback);
  double positive(const std::string& key);  ///< > 0
  double positive(const std::string& key, double fallback);
  double not_negative(const std::string& key);  ///< >= 0
  double not_negative(const std::string& key, double fallback);
  std::string text(const std::string& key);
  std::string text(const std::string& key, const std::string& fallback);
  int integer(const std::string& key, int fallback);
  bool flag(const std::string& key, bool fallback);
  std::vector<double> numbers(const std::string& key);
  std::vector<std::string> texts(const std::string& key);
  Eigen::Vector3d vector3(const std::string& key);
  std::vector<Eigen::Vector3d> vectors3(const std::string& key);
  TomlTable table(const std::string& key);
  std::vector<TomlTable> tables(const std::string& key);
  std::string path(const std::string& key);  ///< of a file, relative to this file's folder
  std::vector<std::string> paths(const std::string& key);
  Band band(const std::string& key);  ///< [lo, hi] or "LO:HI", 0 <= lo < hi

  /// The value that stands for a word, out of {word, value} pairs.
  template <class Value>
  Value choice(const std::string& key, const std::vector<std::pair<std::string, Value>>& values);
  template <class Value>
  Value choice(const std::string& key, const std::vector<std::pair<std::string, Value>>& values,
               Value fallback) {
    return has(key) ? choice(key, values) : fallback;
  }

  const toml::node* node(
      const std::string& key);  ///< for keys of several types; marks the key as known, may be null
  const toml::node& required(const std::string& key);  ///< the same; throws Error when it is missing
  /// Three numbers out of a node that belongs to `key`.
  Eigen::Vector3d vector3(const std::string& key, const toml::node& node) const;

  /// A unit vector out of "x", "y", "z" or a vector, a node that belongs to `key`.
  Eigen::Vector3d direction(const std::string& key, const toml::node& node) const;

  /// The keys that the table has, in no particular order.
  std::vector<std::string> keys() const;
  /// " (is that what 'diametr' stands for?)" where a key that nobody asked for is near the missing one, else
  /// "".
  std::string misspelling_of(const std::string& key) const;
  void finish() const;

  /// "FILE:LINE: PATH.KEY MESSAGE", at the key's line (at the table's when it has no such key).
  Error error(const std::string& key, const std::string& message) const;
  /// The same at the line of a node inside the key's value.
  Error error(const std::string& key, const toml::node& at, const std::string& message) const;
  /// An Error about the table as a whole: "FILE:LINE: PATH: MESSAGE".
  Error error(const std::string& message) const;
  const std::string& file() const { return file_; }
  /// "FILE:LINE" of the table.
  std::string place() const;

 private:
  const toml::array& array(const std::string& key, const std::string& of);
  std::size_t index_of_word(const std::string& key, const std::vector<std::string>& words);
  std::string name(const std::string& key) const;
  long line() const;

  const toml::table* table_;
  std::string file_;
  std::string path_;
  std::set<std::string> known_;
};

template <class Value>
Value TomlTable::choice(const std::string& key, const std::vector<std::pair<std::string, Value>>& values) {
  std::vector<std::string> words;
  for (const auto& pair : values) words.push_back(pair.first);
  return values[index_of_word(key, words)].second;
}

}  // namespace struna::apps
