#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fem/error.hpp"

namespace struna::apps {

/// Wrong usage of the command line: exit 2, where any other Error (input or data at fault) is exit 1.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// The text in small letters (ASCII): words of options and keys may be written in capitals ("H1").
std::string small_letters(std::string text);

/// The value of an option by one of the library's word readers (`estimator_kind`, `mode_method` …): the Error
/// that the reader throws is wrong usage here.
template <class Reader>
auto option_value(const std::string& option, const std::string& word, Reader read) {
  try {
    return read(small_letters(word));
  } catch (const Error& error) {
    throw UsageError(option + ": " + error.reason());
  }
}

/// Runs a step on input files. An Error of the libraries that names no file ("restrict_band: no line …") gets
/// the first of them in front, the one at fault as far as can be told.
template <class Step>
auto blaming(const std::vector<std::string>& files, Step step) {
  try {
    return step();
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    if (error.names_file()) throw;
    throw Error(files.front(), 0, error.reason());
  }
}

/// Type name of an option that names a file to write; those to read are positional, or have `read_file`.
inline constexpr const char* written_file = "OUT";
inline constexpr const char* read_file = "FILE";

/// Throws UsageError when a file to write (by its option) is one of those to read, whatever links lead there,
/// or is written twice. An option
/// that is not given has an empty name. Only regular files count: a terminal or a pipe cannot be overwritten.
void refuse_overwriting(const std::vector<std::pair<std::string, std::string>>& written,
                        const std::vector<std::string>& read);

/// Check of an option in Hz that must be above zero: what is wrong with the text, "" for nothing.
std::string refusal_of_hz(const std::string& text);

/// LO:HI as written on the command line [Hz].
struct Band {
  double lo_hz = 0.0;
  double hi_hz = 0.0;
};
/// Throws UsageError unless 0 <= LO < HI.
Band parse_band(const std::string& text);
/// LO:HI in Pa; throws UsageError unless 0 < LO < HI.
std::pair<double, double> parse_modulus_range(const std::string& text);

}  // namespace struna::apps
