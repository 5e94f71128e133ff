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
                           message),
        names_file_(true) {}

  /// Whether the message begins with the file at fault.
  bool names_file() const noexcept { return names_file_; }

  /// The message without the function's name in front ("at least 3 points, got 2"): for those who do not call
  /// the function, and have given a file or an option instead. A message that names a file stays as it is.
  std::string reason() const {
    const std::string message = what();
    const std::size_t colon = message.find(": ");
    const bool function = !names_file_ && colon != std::string::npos &&
                          message.find_first_not_of(name_characters) >= colon && colon > 0;
    return function ? message.substr(colon + 2) : message;
  }

 private:
  /// Of "find_hit", "MotionHistory::at", "to_string(ModeFlag)".
  static constexpr const char* name_characters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_:()";
  bool names_file_ = false;
};

}  // namespace struna
