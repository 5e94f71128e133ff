#pragma once

#include <stdexcept>
#include <string>

namespace struna {

/// The one error that struna throws: wrong input, or data that cannot be used. The message names the
/// function or file, the rule and the value ("fit_circle: at least 3 points, got 2"), in one line.
/// Numerical outcomes (not converged, not a circle) are not errors: they travel in the results.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;

  /// "FILE:LINE: MESSAGE", the form in which the command line reports a fault in a file. Lines count from 1;
  /// line 0 stands for the file as a whole and is left out.
  Error(const std::string& file, long line, const std::string& message)
      : std::runtime_error(file + (line > 0 ? std::string(":").append(std::to_string(line)) : "") + ": " +
                           message) {}
};

}  // namespace struna
