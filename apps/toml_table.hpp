#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fem/error.hpp"

namespace struna::apps {

/// Parses a TOML file; a syntax error becomes an Error with file and line.
toml::table parse_toml(const std::string& file);

/// A table read key by key. Typed getters throw Error with file and line; finish() refuses keys that nobody asked for
/// (with the nearest known one as a hint).
class TomlTable {
 public:
  TomlTable(const toml::table& table, std::string file, std::string path);

  bool has(const std::string& key) const;
  double number(const std::string& key);
  double number(const std::string& key, double fallback);
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
  const toml::node* node(const std::string& key);  ///< for keys of several types; marks the key as known
  void finish() const;

  /// An Error at the key's line.
  Error error(const std::string& key, const std::string& message) const;

 private:
  const toml::table* table_;
  std::string file_;
  std::string path_;
  std::set<std::string> known_;
};

}  // namespace struna::apps
