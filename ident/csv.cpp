#include "ident/csv.hpp"

// Reading ahead in a second thread gains nothing on a file in the page cache and would use a second core.
#define CSV_IO_NO_THREAD
#if defined(__GNUC__) && !defined(__clang__)
// The library's own error type cuts file names at 255 characters with strncpy and ends them by hand.
#pragma GCC diagnostic ignored "-Wstringop-truncation"
#endif
#include <fmt/format.h>
#include <libfccp/csv.h>

#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

void split(const char* line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  const char* const end = line + std::strlen(line);
  for (const char* begin = line;;) {
    const char* at =
        static_cast<const char*>(std::memchr(begin, separator, static_cast<std::size_t>(end - begin)));
    fields.emplace_back(begin, static_cast<std::size_t>((at ? at : end) - begin));
    if (!at) return;
    begin = at + 1;
  }
}

constexpr std::string_view separators = ",;\t";

/// The separator that leaves no other one within a field of the header; none: '\0'. One column: a comma.
char separator_of(const char* header) {
  std::vector<std::string_view> fields;
  for (const char separator : separators) {
    split(header, separator, fields);
    bool alone = fields.size() > 1 || std::strpbrk(header, separators.data()) == nullptr;
    for (const auto& field : fields) alone &= trimmed(field).find_first_of(separators) == field.npos;
    if (alone) return separator;
  }
  return '\0';
}

/// How the numbers of a row are told apart: constants for the usual file, so that its loop is compiled for
/// them.
struct CommaSeparated {
  static constexpr char separator = ',';
  static constexpr char decimal = '.';
};
struct OtherFormat {
  char separator;
  char decimal;  ///< '\0' before the first number that has one
};

bool blank(const char* line) {
  return line[std::strspn(line, " \t")] == '\0';
}

/// Appends the decimal digits at `at` to `digits` and moves past them.
void take_few_digits(const char*& at, const char* end, std::uint64_t& digits) {
  for (; at < end && static_cast<unsigned char>(*at - '0') < 10; ++at)
    digits = 10 * digits + static_cast<std::uint64_t>(*at - '0');
}

/// The digits that eight characters begin with: how many, and their value. Without a branch on their number.
struct LeadingDigits {
  int count;
  std::uint64_t value;
};

LeadingDigits leading_digits(const char* at) {
  std::uint64_t text;
  std::memcpy(&text, at, 8);
  constexpr std::uint64_t ones = 0x0101010101010101;
  const std::uint64_t value = text - ones * '0';
  // A character below '0' or above '9' sets its top bit in one of the two sums; carries reach later ones
  // only.
  const std::uint64_t others = (value | (text + ones * (127 - '9'))) & (ones * 0x80);
  const int count = std::countr_zero(others) / 8;
  const std::uint64_t digits = (value << (4 * (8 - count)))
                               << (4 * (8 - count));        // zeros lead; none: all out
  const std::uint64_t pairs = 10 * digits + (digits >> 8);  // two digits in every other byte
  constexpr std::uint64_t mask = 0x000000ff000000ff;
  const std::uint64_t first_and_third = (pairs & mask) * (100 + (std::uint64_t(1000000) << 32));
  const std::uint64_t second_and_fourth = ((pairs >> 16) & mask) * (1 + (std::uint64_t(10000) << 32));
  return {count, (first_and_third + second_and_fourth) >> 32};
}

/// The same for the many digits of a fraction: sixteen at once, in registers, where there are as many
/// characters.
void take_digits(const char*& at, const char* end, std::uint64_t& digits) {
  static constexpr std::uint64_t tens[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
  if (std::endian::native == std::endian::little && end - at >= 16) {
    const LeadingDigits first = leading_digits(at);
    const LeadingDigits second = first.count == 8 ? leading_digits(at + 8) : LeadingDigits{0, 0};
    digits = (digits * tens[first.count] + first.value) * tens[second.count] + second.value;
    at += first.count + second.count;
    if (second.count < 8) return;
  }
  take_few_digits(at, end, digits);
}

/// The numbers that records are full of, at `at`, which moves past them: digits that fit a double, times a
/// power of ten that does, so that one multiplication or division rounds once and correctly (Clinger, PLDI
/// 1990, fast path). `last_digit` becomes the power of ten of the last one. False, with `at` anywhere: left
/// to from_chars.
template <class Format>
bool take_short_number(const char*& at, const char* end, const Format& format, double& value,
                       int& last_digit) {
  static constexpr double tens[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const bool negative = at < end && *at == '-';
  at += negative;
  std::uint64_t digits = 0;
  const char* const begin = at;
  take_few_digits(at, end, digits);
  long count = at - begin;
  int exponent = 0;
  if (at < end && *at == format.decimal) {
    const char* const fraction = ++at;
    take_digits(at, end, digits);
    exponent = static_cast<int>(fraction - at);
    count -= exponent;
  }
  if (count == 0 || count > 15) return false;
  if (at < end && (*at == 'e' || *at == 'E')) {
    ++at;
    const bool minus = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+')) ++at;
    const char* const first = at;
    std::uint64_t written = 0;
    take_few_digits(at, end, written);
    if (at == first || at - first > 2) return false;
    exponent += minus ? -static_cast<int>(written) : static_cast<int>(written);
  }
  if (exponent > 22 || exponent < -22) return false;
  const double magnitude = static_cast<double>(digits);
  const double scaled = exponent < 0 ? magnitude / tens[-exponent] : magnitude * tens[exponent];
  value = negative ? -scaled : scaled;
  last_digit = exponent;
  return true;
}

/// Power of ten of the last digit of a number written in any way: -3 for "0.125", 1 for "1.2e2".
int last_digit_of(std::string_view text) {
  const auto exponent_at = text.find_first_of("eE");
  int exponent = 0;
  if (exponent_at != text.npos) {
    const char* begin = text.data() + exponent_at + 1;
    const char* const end = text.data() + text.size();
    if (begin < end && *begin == '+') ++begin;
    std::from_chars(begin, end, exponent);
  }
  const std::string_view mantissa = trimmed(text.substr(0, exponent_at));
  const auto point = mantissa.find_first_of(".,");
  return point == mantissa.npos ? exponent : exponent - static_cast<int>(mantissa.size() - point - 1);
}

/// A number out of the whole text, with the blanks and the leading '+' that from_chars does not take.
bool parse(std::string_view text, double& value) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return false;
  // Too small for a double reads as zero, too large as infinity, as strtod has it.
  if (fault == std::errc::result_out_of_range) value = std::strtod(std::string(text).c_str(), nullptr);
  return fault == std::errc() || fault == std::errc::result_out_of_range;
}

std::string with_point(std::string_view text, std::size_t mark) {
  std::string copy(text);
  copy[mark] = '.';
  return copy;
}

}  // namespace

namespace {

/// The lines of a file through the library's reader, a slice of the file at a time: alone it goes through a
/// buffer of 48 MiB, which every line would have to be fetched from memory for, and takes half as long again.
class SlicedLines {
 public:
  SlicedLines(const std::string& name, std::FILE* stream) : name_(name), stream_(stream, std::fclose) {
    std::setvbuf(stream, nullptr, _IONBF, 0);
  }

  /// The next line, valid until the call after; null at the end. Throws Error on a line longer than 16 MiB.
  char* next() {
    while (true) {
      if (slice_)
        if (char* const line = slice_->next_line()) {
          ++line_;
          return line;
        }
      if (!next_slice()) return nullptr;
    }
  }

  /// Number of the line last returned, from 1.
  long line() const { return line_; }

 private:
  static constexpr std::size_t usual = std::size_t(1) << 18;  // bytes: well within a second-level cache
  static constexpr std::size_t longest = std::size_t(1) << 24;

  /// Reads on, up to the end of the last whole line.
  bool next_slice() {
    text_.erase(0, taken_);
    const auto ends_at = [&] {
      const std::size_t last = text_.rfind('\n');
      return last == text_.npos ? 0 : last + 1;
    };
    taken_ = 0;
    while (taken_ == 0) {
      const std::size_t kept = text_.size();
      if (kept > longest) throw Error(name_, line_ + 1, "a line is longer than 16 MiB: this is no CSV file");
      text_.resize(std::max(usual, 2 * kept));
      const std::size_t got = std::fread(text_.data() + kept, 1, text_.size() - kept, stream_.get());
      text_.resize(kept + got);
      taken_ = got == 0 ? text_.size() : ends_at();
      if (text_.empty()) return false;
    }
    slice_.emplace(name_, text_.data(), text_.data() + taken_);
    return true;
  }

  std::string name_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream_;
  std::string text_;       ///< the slice, and the beginning of the next one
  std::size_t taken_ = 0;  ///< size of the slice
  std::optional<io::LineReader> slice_;
  long line_ = 0;
};

}  // namespace

struct CsvReader::State {
  std::string file;
  char separator = ',';
  char decimal = '.';  ///< '\0' until the first number that has one, where the separator leaves both
  SlicedLines lines;
  std::vector<ColumnHeader> header;
  std::vector<std::string_view> fields;  ///< of a row that next_numbers reads in full

  explicit State(const std::string& name) : file(name), lines(name, open(name)) {}

  static std::FILE* open(const std::string& name) {
    if (std::filesystem::is_directory(name)) throw Error(name, 0, "is a folder, a CSV file is needed");
    std::FILE* stream = std::fopen(name.c_str(), "rb");
    if (!stream) throw Error(name, 0, fmt::format("cannot be opened: {}", std::strerror(errno)));
    return stream;
  }

  long line() const { return lines.line(); }
  const char* next_line() { return lines.next(); }
};

CsvReader::CsvReader(const std::string& file) : state_(std::make_unique<State>(file)) {
  const char* line = state_->next_line();
  if (!line || blank(line))
    throw Error(file, 1, "no header row: the first line must name the columns, 'name [unit]'");
  state_->separator = separator_of(line);
  if (state_->separator == '\0')
    throw Error(file, 1,
                "the header can be split at more than one of comma, semicolon and tab: use one of them only");
  if (state_->separator != ',') state_->decimal = '\0';
  std::vector<std::string_view> fields;
  split(line, state_->separator, fields);
  for (const auto& field : fields) {
    ColumnHeader column = parse_column_header(std::string(field));
    if (!column.name.empty() && find(column.name) >= 0)
      throw Error(file, 1, fmt::format("two columns are named '{}': names must differ", column.name));
    state_->header.push_back(std::move(column));
  }
}

CsvReader::~CsvReader() = default;
CsvReader::CsvReader(CsvReader&&) noexcept = default;

const std::string& CsvReader::file() const {
  return state_->file;
}
const std::vector<ColumnHeader>& CsvReader::header() const {
  return state_->header;
}
long CsvReader::line() const {
  return state_->line();
}

int CsvReader::find(const std::string& name) const {
  for (std::size_t i = 0; i < state_->header.size(); ++i)
    if (state_->header[i].name == name) return static_cast<int>(i);
  return -1;
}

int CsvReader::column(const std::string& name) const {
  const int index = find(name);
  if (index >= 0) return index;
  std::string there;
  for (const auto& column : state_->header) there += (there.empty() ? "" : ", ") + column.name;
  throw Error(file(), 1, fmt::format("no column '{}': there are {}", name, there));
}

bool CsvReader::next(std::vector<std::string_view>& fields) {
  const char* text = state_->next_line();
  return text && accept(text, fields);
}

bool CsvReader::accept(const char* text, std::vector<std::string_view>& fields) {
  split(text, state_->separator, fields);
  if (fields.size() == state_->header.size() && !(fields.size() == 1 && blank(text))) return true;
  if (!blank(text))
    throw Error(file(), line(),
                fmt::format("{} fields, the header has {}{}", fields.size(), state_->header.size(),
                            state_->separator == ',' && fields.size() > state_->header.size()
                                ? ": with decimal commas, columns must be separated by semicolons or tabs"
                                : ""));
  const long first_blank = line();
  while ((text = state_->next_line()))
    if (!blank(text)) throw Error(file(), first_blank, "an empty line between rows: take it out");
  return false;
}

bool CsvReader::next_numbers(const std::vector<int>& slots, std::vector<double>& numbers, int& last_digit) {
  if (state_->separator == ',') return read_numbers(CommaSeparated{}, slots, numbers, last_digit);
  return read_numbers(OtherFormat{state_->separator, state_->decimal}, slots, numbers, last_digit);
}

template <class Format>
bool CsvReader::read_numbers(const Format& format, const std::vector<int>& slots,
                             std::vector<double>& numbers, int& last_digit) {
  const char* const text = state_->next_line();
  if (!text) return false;
  const char* const end = text + std::strlen(text);
  const char* at = text;
  std::size_t column = 0;
  bool plain = true;
  for (; column < slots.size(); ++column, ++at) {
    if (slots[column] < 0) {
      at = static_cast<const char*>(std::memchr(at, format.separator, static_cast<std::size_t>(end - at)));
      if (!at) at = end;
    } else {
      int place = 0;
      plain = take_short_number(at, end, format, numbers[static_cast<std::size_t>(slots[column])], place);
      if (!plain) break;
      if (slots[column] == 0) last_digit = place;
    }
    if (at == end || *at != format.separator) break;
  }
  if (plain && at == end && column + 1 == slots.size()) return true;
  // Blanks, long or odd numbers, faults: in full.
  if (!accept(text, state_->fields)) return false;
  for (column = 0; column < slots.size(); ++column) {
    if (slots[column] < 0) continue;
    numbers[static_cast<std::size_t>(slots[column])] = number(state_->fields, static_cast<int>(column));
    if (slots[column] == 0) last_digit = last_digit_of(state_->fields[column]);
  }
  return true;
}

double CsvReader::number(const std::vector<std::string_view>& fields, int column) const {
  const std::string_view text = fields[static_cast<std::size_t>(column)];
  const std::string& name = state_->header[static_cast<std::size_t>(column)].name;
  const std::size_t mark = text.find_first_of(state_->separator == ',' ? "." : ".,");
  if (mark != text.npos && state_->decimal != '\0' && text[mark] != state_->decimal)
    throw Error(file(), line(),
                fmt::format("column '{}' holds '{}', but numbers before it have a decimal {}: one of the two "
                            "throughout is needed",
                            name, text.substr(0, 40), state_->decimal == ',' ? "comma" : "point"));
  double value = 0.0;
  const bool read =
      mark != text.npos && text[mark] == ',' ? parse(with_point(text, mark), value) : parse(text, value);
  if (read && mark != text.npos) state_->decimal = text[mark];
  if (read && std::isfinite(value)) return value;
  if (trimmed(text).empty())
    throw Error(file(), line(), fmt::format("column '{}' is empty: a number is needed", name));
  throw Error(file(), line(),
              fmt::format("column '{}' holds '{}': a finite number is needed", name, text.substr(0, 40)));
}

}  // namespace struna::ident
