#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "ident/units.hpp"

namespace struna::ident {

/// Rows of a CSV file, streamed line by line (fast-cpp-csv-parser underneath). Every row must have as many
/// fields as the header; blank lines at the end are passed over. Faults are Errors with file and line.
///
/// Fields are separated by commas, semicolons or tabs: by the one that leaves none of the others within a
/// field of the header (Error where none does). Where it is no comma, numbers may have a decimal comma
/// instead of a point, but not now this, now that.
class CsvReader {
 public:
  explicit CsvReader(const std::string& file);
  ~CsvReader();
  CsvReader(CsvReader&&) noexcept;

  const std::string& file() const;
  const std::vector<ColumnHeader>& header() const;
  /// Index of the column `name`, or -1.
  int find(const std::string& name) const;
  /// The same; throws Error that tells the columns there are.
  int column(const std::string& name) const;

  /// The next row's fields, valid until the next call; false at the end.
  bool next(std::vector<std::string_view>& fields);
  /// The next row's numbers, for long files: the one in column i goes to numbers[slots[i]], columns with a
  /// negative slot are not looked into; `slots` has an entry per column. `last_digit` becomes the power of
  /// ten of the last digit that numbers[0] was written with. Faults as in number().
  bool next_numbers(const std::vector<int>& slots, std::vector<double>& numbers, int& last_digit);
  /// Number of the row's line in the file, from 1.
  long line() const;
  /// A field as a finite number; Error with file, line and column name for text, an empty field, NaN,
  /// infinity.
  double number(const std::vector<std::string_view>& fields, int column) const;

 private:
  bool accept(const char* text, std::vector<std::string_view>& fields);
  template <class Format>
  bool read_numbers(const Format& format, const std::vector<int>& slots, std::vector<double>& numbers,
                    int& last_digit);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace struna::ident
