#include "apps/console.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "fem/error.hpp"

namespace struna::apps {
namespace {

bool quiet_ = false;

/// Characters, not bytes: continuation bytes of UTF-8 take no room.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

bool looks_like_a_number(const std::string& text) {
  return text.empty() || text == "-" || text == "nan" || text.find_first_of("0123456789") <= 1;
}

bool is_numeric_column(const Table& table, std::size_t column) {
  return std::all_of(table.rows.begin(), table.rows.end(), [&](const auto& row) {
    return column >= row.size() || looks_like_a_number(row[column]);
  });
}

std::string padded(const std::string& text, std::size_t to, bool right) {
  const std::string blanks(to - width(text), ' ');
  return right ? blanks + text : text + blanks;
}

}  // namespace

void set_quiet(bool quiet) {
  quiet_ = quiet;
}

void progress(const std::string& message) {
  if (!quiet_ && isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "%s\n", one_line(message).c_str());
}

void warn(const std::string& message) {
  std::fprintf(stderr, "warning: %s\n", one_line(message).c_str());
}

std::string format(const Table& table) {
  const std::size_t columns = table.header.size();
  std::vector<std::size_t> widths(columns);
  for (std::size_t c = 0; c < columns; ++c) widths[c] = width(table.header[c]);
  for (const auto& row : table.rows) {
    if (row.size() > columns) {
      throw Error("format: a row has at most the header's " + std::to_string(columns) + " fields, got " +
                  std::to_string(row.size()));
    }
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width(row[c]));
  }

  std::string text;
  const auto add_line = [&](const std::vector<std::string>& fields) {
    std::string line;
    for (std::size_t c = 0; c < fields.size(); ++c) {
      line += (c > 0 ? "  " : "") + padded(fields[c], widths[c], is_numeric_column(table, c));
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add_line(table.header);
  for (const auto& row : table.rows) add_line(row);
  return text;
}

void print(const Table& table) {
  if (!quiet_) std::fputs(format(table).c_str(), stdout);
}

void print(const std::string& line) {
  if (!quiet_) std::printf("%s\n", line.c_str());
}

std::string one_line(const std::string& message) {
  std::string line = message;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; },
      ' ');
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

}  // namespace struna::apps
