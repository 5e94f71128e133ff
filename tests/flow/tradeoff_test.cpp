// `struna tradeoff`: files that it writes, data that it takes, faults that it tells.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

const std::string scene = replaced(replaced(straight_wire_scene, "0.68", "0.3"), "elements = 10\n", "");

/// Fields of the rows of a CSV text, without the header.
std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
  }
  return rows;
}

TEST(Tradeoff, WritesTheTableThePageAndAPicturePerStage) {
  const Folder folder;
  folder.write("scene.toml", scene);
  const auto run = run_struna("tradeoff --scene scene.toml --band 50:600 -o out", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string csv = read_text(folder / "out/tradeoff.csv");
  EXPECT_THAT(csv, StartsWith("stage,problem,method,knob,value,error,time_s,pareto,default"));
  int fronts = 0, defaults = 0;
  for (const auto& row : rows_of(csv)) {
    ASSERT_EQ(row.size(), 11u);
    EXPECT_TRUE(row[0] == "model" || row[0] == "harmonic") << row[0];
    EXPECT_GE(std::stod(row[5]), 0.0);
    EXPECT_GT(std::stod(row[6]), 0.0);
    fronts += row[7] == "1";
    defaults += row[8] == "1";
  }
  EXPECT_EQ(defaults, 3);  // natural frequencies, transfer function, harmonic
  EXPECT_GE(fronts, 3);
  EXPECT_THAT(read_text(folder / "out/tradeoff_model.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(read_text(folder / "out/tradeoff_harmonic.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(read_text(folder / "out/index.html"), HasSubstr("scene.toml: transfer function"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "out"), fs::directory_iterator()), 4);
  EXPECT_THAT(run.out, HasSubstr("For "));
}

TEST(Tradeoff, OnlyTheStageAskedForIsMeasured) {
  const Folder folder;
  folder.write("scene.toml", scene);
  const auto run = run_struna("tradeoff --stage model --scene scene.toml --band 50:600 -o out", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(folder / "out/tradeoff_model.svg"));
  EXPECT_FALSE(fs::exists(folder / "out/tradeoff_harmonic.svg"));
}

TEST(Tradeoff, TellsFaultsInOneLineAndLeavesNothing) {
  const Folder folder;
  folder.write("scene.toml", scene);
  folder.write("still.toml", scene.substr(0, scene.find("[drive]")));
  std::string soft = scene;
  soft.erase(soft.find("youngs_modulus = 120e9\n"), 23);
  folder.write("soft.toml", soft);
  folder.write("file", "");
  struct Fault {
    std::string arguments;
    int exit_code;
    std::string says;
  };
  for (const auto& fault :
       {Fault{"--stage moods -o out", 2, "--stage: must be transfer, modes, model, harmonic or simulation"},
        Fault{"--stage modes --scene scene.toml -o out", 2, "the data given speak of model, harmonic only"},
        Fault{"--scene absent.toml -o out", 1, "absent.toml"},
        Fault{"--scene still.toml -o out", 1, "still.toml"},
        Fault{"--scene soft.toml -o out", 1, "soft.toml"},
        Fault{"--scene scene.toml --band 600:50 -o out", 2, "a band LO:HI needs"},
        Fault{"--trfam absent.csv -o out", 1, "absent.csv"},
        Fault{"--study absent.toml -o out", 1, "absent.toml"}, Fault{"--stage model -o file", 1, "file"},
        Fault{"--band 10:100 -o out", 2, "--scene"}, Fault{"--stage model", 2, "-o"}}) {
    const auto run = run_struna("tradeoff " + fault.arguments, folder);
    EXPECT_EQ(run.exit_code, fault.exit_code) << fault.arguments << "\n" << run.err;
    EXPECT_THAT(run.err, StartsWith("struna: ")) << fault.arguments;
    EXPECT_THAT(run.err, HasSubstr(fault.says)) << fault.arguments;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(fs::exists(folder / "out")) << fault.arguments;
  }
}

TEST(Tradeoff, TakesAMeasuredFunction) {
  const Folder folder;
  const auto file = sample_data("curved_wire/true_trfam.csv").string();
  const auto run = run_struna("tradeoff --trfam '" + file + "' -o out", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(read_text(folder / "out/tradeoff.csv"), HasSubstr("\nmodes,true_trfam.csv: loss factor,"));
}

TEST(Tradeoff, AFunctionWithoutASoundModeIsNoReference) {
  const Folder folder;  // its one mode is flagged
  const auto run =
      run_struna("tradeoff --trfam '" + sample_data("slater/case1_frf.csv").string() + "' -o out", folder);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("no mode without a flag (1 in all)"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace
}  // namespace struna::tests
