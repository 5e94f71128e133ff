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

/// The value of an option by one of the library's word readers (`estimator_kind`, `mode_method` …): the Error
/// that the reader throws is wrong usage here.
template <class Reader>
auto option_value(const std::string& option, const std::string& word, Reader read) {
  try {
    return read(word);
  } catch (const Error& error) {
    throw UsageError(option + ": " + error.what());
  }
}

/// Runs a step on input files. An Error of the libraries that names none of the files ("restrict_band: no
/// line …") gets the first of them in front, the one at fault as far as can be told.
template <class Step>
auto blaming(const std::vector<std::string>& files, Step step) {
  try {
    return step();
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    const std::string message = error.what();
    for (const auto& file : files) {
      if (message.starts_with(file + ":")) throw;
    }
    throw Error(files.front(), 0, message);
  }
}

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
