#pragma once

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
  const std::string line = "cd '" + folder.path().string() + "' && '" STRUNA_PROGRAM "' " + arguments + " >'" +
                           out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(line.c_str());
  ProgramRun run{WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(out), read_text(err)};
  std::filesystem::remove(out);
  std::filesystem::remove(err);
  return run;
}

inline std::filesystem::path sample_data(const std::string& name) {
  return std::filesystem::path(STRUNA_SOURCE_DIR) / "sample_data" / name;
}

}  // namespace struna::tests
