// The curved wire's stages and the whole of `struna identify`, best of several runs, one thread: what a user
// waits for.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "ident/mode_identification.hpp"
#include "ident/transfer_function.hpp"
#include "tests/bench/stopwatch.hpp"

namespace {

using namespace struna;

ident::ModeOptions with_method(ident::ModeMethod method) {
  ident::ModeOptions options;
  options.method = method;
  return options;
}

void report(const char* what, double seconds, double limit) {
  fmt::print("{:<44}{:>12.1f}{:>12.0f}\n", what, 1e3 * seconds, 1e3 * limit);
}

}  // namespace

int main() {
  const std::string folder = STRUNA_SOURCE_DIR "/sample_data/curved_wire/";
  const std::vector<std::string> outputs = {"force_x", "force_y", "force_z"};
  const auto estimate = [&] {
    return ident::restrict_band(
        ident::estimate_transfer_function(
            ident::welch_spectra({folder + "records.csv"}, "displacement", outputs, {}),
            ident::Estimator::h1),
        10.0, 1000.0);
  };
  const ident::TransferFunction tf = estimate();
  std::size_t modes = 0;
  const auto identify = [&](ident::ModeMethod method) {
    return tests::best_seconds(10,
                               [&] { modes += ident::identify_modes(tf, with_method(method)).modes.size(); });
  };

  fmt::print("{:<44}{:>12}{:>12}\n", "curved wire, 30 s of four channels", "time [ms]", "limit [ms]");
  report("records to three transfer functions",
         tests::best_seconds(10, [&] { modes += estimate().outputs.size(); }), 2.0);
  report("all circle fits, resonances found", identify(ident::ModeMethod::circle), 0.05);
  report("multi-mode fit, automatic", identify(ident::ModeMethod::automatic), 2.0);

  const auto result = std::filesystem::temp_directory_path() / "struna_identify_bench";
  const std::string command = std::string("'" STRUNA_PROGRAM "' --quiet identify '") + folder +
                              "study.toml' -o '" + result.string() + "' 2>/dev/null";
  bool ran = true;
  const double whole = tests::best_seconds(3, [&] { ran = ran && std::system(command.c_str()) == 0; });
  std::filesystem::remove_all(result);
  if (!ran) {
    fmt::print(stderr, "identify_bench: the program failed: {}\n", command);
    return 1;
  }
  report("struna identify, everything", whole, 2.0);
  return modes > 0 ? 0 : 1;
}
