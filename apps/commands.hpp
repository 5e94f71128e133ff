#pragma once

#include <CLI/CLI.hpp>

#include <string>

#include "ident/transfer_function.hpp"

namespace struna::apps {

// One function per command: declares its options on `app` and, when chosen, runs.
void add_frf(CLI::App& app);
void add_modes(CLI::App& app);
void add_fit(CLI::App& app);
void add_predict(CLI::App& app);
void add_compare(CLI::App& app);
void add_identify(CLI::App& app);
void add_eigen(CLI::App& app);

/// LO:HI as written on the command line [Hz].
struct Band {
  double lo_hz = 0.0;
  double hi_hz = 0.0;
};
Band parse_band(const std::string& text);

}  // namespace struna::apps
