// Every command tells how it is used, and what the docs show works: each line `struna …` in a block marked
// ```sh of README.md, docs/*.md and sample_data/README.md is run, block by block, in a folder that holds a
// copy of the sample data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::vector<std::string> commands = {"frf",      "modes", "fit",      "predict", "compare",
                                           "identify", "eigen", "simulate", "tradeoff"};

TEST(Commands, HelpListsEveryCommand) {
  const Folder folder;
  const ProgramRun run = run_struna("--help", folder);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  for (const auto& command : commands) EXPECT_THAT(run.out, HasSubstr("\n  " + command + " ")) << command;
  EXPECT_THAT(run.out, HasSubstr("struna identify "));
}

TEST(Commands, EveryCommandsHelpShowsAnExample) {
  const Folder folder;
  for (const auto& command : commands) {
    const ProgramRun run = run_struna(command + " --help", folder);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "") << command;
    EXPECT_THAT(run.out, HasSubstr("Example")) << command;
    EXPECT_THAT(run.out, HasSubstr("\n  struna " + command + " ")) << command;
  }
}

TEST(Commands, VersionIsTheProjects) {
  const Folder folder;
  const ProgramRun run = run_struna("--version", folder);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "struna " STRUNA_VERSION "\n");
}

TEST(Commands, QuietSaysNothingBeforeOrAfterTheCommand) {
  const Folder folder;
  folder.write("s.toml", read_text(sample_data("straight_wire/scene.toml")));
  EXPECT_NE(run_struna("eigen s.toml --modes 3", folder).out, "");
  for (const char* arguments :
       {"--quiet eigen s.toml --modes 3 -o e.csv", "eigen s.toml --modes 3 -o e.csv --quiet"}) {
    const ProgramRun run = run_struna(arguments, folder);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out, "") << arguments;
    EXPECT_EQ(run.err, "") << arguments;
  }
  EXPECT_THAT(read_text(folder / "e.csv"), HasSubstr("natural_frequency [Hz]"));
}

/// A block of commands in a document: the arguments of each `struna` line.
struct Block {
  std::string document;
  int line = 0;
  std::vector<std::string> arguments;
};

std::vector<Block> blocks_in(const fs::path& document) {
  std::ifstream in(document);
  std::vector<Block> blocks;
  std::string line;
  bool inside = false;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.rfind("```", 0) == 0) {
      inside = !inside && line == "```sh";
      if (inside) blocks.push_back({document.filename().string(), number, {}});
    } else if (inside && line.rfind("struna ", 0) == 0) {
      while (!line.empty() && line.back() == '\\') {  // continued on the next line
        std::string more;
        std::getline(in, more);
        ++number;
        line = line.substr(0, line.size() - 1) + more;
      }
      blocks.back().arguments.push_back(line.substr(7));
    }
  }
  return blocks;
}

std::vector<fs::path> documents() {
  const fs::path root = STRUNA_SOURCE_DIR;
  std::vector<fs::path> paths = {root / "README.md", root / "sample_data/README.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") paths.push_back(entry.path());
  }
  return paths;
}

TEST(Commands, ShownInTheDocsRun) {
  int run_count = 0;
  for (const auto& document : documents()) {
    ASSERT_TRUE(fs::exists(document)) << document;
    for (const auto& block : blocks_in(document)) {
      const Folder folder;
      fs::create_directory_symlink(fs::path(STRUNA_SOURCE_DIR) / "sample_data", folder / "sample_data");
      for (const auto& arguments : block.arguments) {
        const ProgramRun run = run_struna(arguments, folder);
        EXPECT_EQ(run.exit_code, 0) << block.document << ":" << block.line << ": struna " << arguments << "\n"
                                    << run.err;
        ++run_count;
      }
    }
  }
  EXPECT_GE(run_count, 5);  // the convention is in use
}

}  // namespace
}  // namespace struna::tests
