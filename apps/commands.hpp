#pragma once

#include <CLI/CLI.hpp>

#include "apps/usage.hpp"

namespace struna::apps {

// One function per command: declares its options on `app` and, when chosen, runs.
void add_frf(CLI::App& app);
void add_modes(CLI::App& app);
void add_fit(CLI::App& app);
void add_predict(CLI::App& app);
void add_compare(CLI::App& app);
void add_variation(CLI::App& app);
void add_identify(CLI::App& app);
void add_eigen(CLI::App& app);
void add_simulate(CLI::App& app);
void add_tradeoff(CLI::App& app);
void add_limits(CLI::App& app);

/// The program: parses the arguments, runs the command, returns the exit code (0, 1 or 2).
int run(int argc, const char* const* argv);

}  // namespace struna::apps
