#pragma once

#include <string>
#include <vector>

namespace struna::apps {

/// --quiet: no progress, no tables; warnings stay.
void set_quiet(bool quiet);

void progress(const std::string& message);  ///< stderr, only to a terminal and not when quiet
void warn(const std::string& message);      ///< stderr, "warning: …"

/// A table on stdout, columns aligned (numbers to the right, words to the left), left out when quiet.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};
void print(const Table& table);
void print(const std::string& line);

/// The text that print(table) writes. Throws Error on a row with more fields than the header.
std::string format(const Table& table);

/// Message on one line, control characters as blanks: what stderr shows of an error.
std::string one_line(const std::string& message);

}  // namespace struna::apps
