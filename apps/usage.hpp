#pragma once

#include <string>

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

/// LO:HI as written on the command line [Hz].
struct Band {
  double lo_hz = 0.0;
  double hi_hz = 0.0;
};
/// Throws UsageError unless 0 <= LO < HI.
Band parse_band(const std::string& text);

}  // namespace struna::apps
