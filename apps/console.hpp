#pragma once

#include <string>
#include <vector>

namespace struna::apps {

/// --quiet: no progress, no tables; warnings stay.
void set_quiet(bool quiet);

void progress(const std::string& message);  ///< stderr, left out when quiet
void warn(const std::string& message);      ///< stderr, "warning: …"

/// A table on stdout, columns aligned, left out when quiet.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};
void print(const Table& table);
void print(const std::string& line);

}  // namespace struna::apps
