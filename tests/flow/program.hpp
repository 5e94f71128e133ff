#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/folder.hpp"

namespace struna::tests {

/// What a run of a command line gave.
struct ProgramRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs `struna ARGUMENTS` (a shell line) inside `folder`.
inline ProgramRun run_struna(const std::string& arguments, const Folder& folder) {
  const auto out = folder / ".stdout";
  const auto err = folder / ".stderr";
  const std::string line = "cd '" + folder.path().string() + "' && '" STRUNA_PROGRAM "' " + arguments +
                           " >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(line.c_str());
  ProgramRun run{WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(out), read_text(err)};
  std::filesystem::remove(out);
  std::filesystem::remove(err);
  return run;
}

inline std::filesystem::path sample_data(const std::string& name) {
  return std::filesystem::path(STRUNA_SOURCE_DIR) / "sample_data" / name;
}

/// The text with the first `from` in it, which must be there, changed to `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A straight clamped wire shaken at one end, measured at the other.
inline const std::string straight_wire_scene = R"([[body]]
name = "wire"
points = [[0,0,0], [0.68,0,0]]
diameter = 0.0032
density = 7650
elements = 10
[body.material]
youngs_modulus = 120e9
loss_factor = 0.02
[drive]
support = "wire.start"
direction = "y"
[measure]
support = "wire.end"
directions = ["y"]
)";

}  // namespace struna::tests
