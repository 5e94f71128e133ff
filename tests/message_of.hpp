#pragma once

#include <string>

#include "fem/error.hpp"

namespace struna::tests {

/// The message of the Error that `step()` throws; "no error" when it throws none.
template <class Step>
std::string message_of(Step step) {
  try {
    step();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace struna::tests
