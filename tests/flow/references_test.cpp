// Runs with the shaker along one direction after the other, from simulated records to a comparison.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ident/comparison.hpp"
#include "ident/mode_file.hpp"
#include "ident/parameter_file.hpp"
#include "ident/transfer_function_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A slightly bowed wire whose doublets lie far within a bandwidth, shaken along `direction`.
std::string scene(const std::string& direction, unsigned seed) {
  return R"([[body]]
name = "wire"
points = [[0, 0, 0], [0.2, 0.0033, 0.0022], [0.4, 0.0024, 0.0016], [0.6, 0, 0]]
diameter = 0.0032
second_moment = 3.1083e-12
density = 7650
elements = 16
  [body.material]
  youngs_modulus = 100e9
  loss_factor = 0.02
  damping = "structural"
[drive]
support = "wire.start"
direction = ")" +
         direction + R"("
[measure]
support = "wire.end"
directions = ["x", "y", "z"]
[simulation]
duration = 30
sample_rate = 1000
excitation = { kind = "random", band = [10, 260], rms_acceleration = 20, seed = )" +
         std::to_string(seed) + " }\n";
}

/// The same without what is to be identified.
std::string unknown_scene() {
  std::string text = scene("y", 1);
  const auto from = text.find("  [body.material]");
  return text.erase(from, text.find("[drive]") - from);
}

const char* const study = R"(scene = "unknown.toml"
input = "displacement"
outputs = ["force_y", "force_z"]
[transfer]
band = [12, 250]
[[reference]]
direction = "y"
records = ["y.csv"]
[[reference]]
direction = "z"
records = ["z.csv"]
)";

class References : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    for (const std::string axis : {"y", "z"}) {
      folder_->write(axis + ".toml", scene(axis, axis == "y" ? 1 : 2));
      const auto run = run_struna("simulate " + axis + ".toml -o " + axis + ".csv", *folder_);
      ASSERT_EQ(run.exit_code, 0) << run.err;
    }
    folder_->write("unknown.toml", unknown_scene());
    folder_->write("study.toml", study);
  }
  static void TearDownTestSuite() { delete folder_; }
  static Folder* folder_;
};
Folder* References::folder_ = nullptr;

TEST_F(References, StudyOfTwoPartsDoubletsAndComparesEachReference) {
  const auto run = run_struna("identify study.toml -o out", *folder_);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto file = [&](const std::string& name) { return (*folder_ / ("out/" + name)).string(); };
  const auto measured = ident::read_transfer_function(file("trfam.csv"));
  const auto predicted = ident::read_transfer_function(file("predicted.csv"));
  for (const auto& tf : {measured, predicted}) {
    std::vector<std::string> names;
    for (const auto& output : tf.outputs) names.push_back(output.name);
    EXPECT_THAT(names, ElementsAre("force_y", "force_z", "force_y@z", "force_z@z"));
  }
  for (const auto& output : ident::compare(measured, predicted).outputs)
    EXPECT_GT(output.frac, 0.99) << output.output;

  // Three doublets below 250 Hz, E and eta as simulated: to the mesh's and the floors' 0.3 % and 3 %.
  const auto modes = ident::read_modes(file("modes.csv"));
  EXPECT_GE(modes.modes.size(), 5u);
  const auto identified = ident::read_parameters(file("identified.toml"));
  ASSERT_GE(identified.modulus.value.size(), 5);
  for (const double modulus : identified.modulus.value) EXPECT_NEAR(modulus, 100e9, 0.003 * 100e9);
  for (const double eta : identified.loss_factor.value) EXPECT_NEAR(eta, 0.02, 0.03 * 0.02);

  // The same step by step.
  for (const std::string axis : {"y", "z"}) {
    const auto frf =
        run_struna("frf " + axis + ".csv --input displacement --output force_y --output force_z " +
                       "--band 12:250 -o tf_" + axis + ".csv",
                   *folder_);
    ASSERT_EQ(frf.exit_code, 0) << frf.err;
  }
  const auto step = run_struna("modes tf_y.csv tf_z.csv --references y,z -o modes.csv", *folder_);
  ASSERT_EQ(step.exit_code, 0) << step.err;
  const auto stepwise = ident::read_modes((*folder_ / "modes.csv").string());
  EXPECT_EQ(stepwise.outputs, modes.outputs);
  ASSERT_EQ(stepwise.modes.size(), modes.modes.size());
  for (std::size_t r = 0; r < modes.modes.size(); ++r)  // the files' digits
    EXPECT_NEAR(stepwise.modes[r].natural_frequency_hz, modes.modes[r].natural_frequency_hz, 1e-4);
  const auto fit = run_struna("fit unknown.toml modes.csv -o identified.toml", *folder_);
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const auto again = ident::read_parameters((*folder_ / "identified.toml").string());
  ASSERT_EQ(again.modulus.value.size(), identified.modulus.value.size());
  const auto like = run_struna("predict y.toml --like out/trfam.csv -o predicted.csv", *folder_);
  ASSERT_EQ(like.exit_code, 0) << like.err;
}

TEST_F(References, WhatCannotBeCombinedIsRefused) {
  const auto message = [&](const std::string& arguments) {
    const auto run = run_struna(arguments, *folder_);
    EXPECT_NE(run.exit_code, 0);
    return run.err;
  };
  std::string text = study;
  folder_->write("both.toml", "records = [\"y.csv\"]\n" + text);
  EXPECT_THAT(message("identify both.toml -o no"),
              HasSubstr("both.toml:1: records contradicts [[reference]]"));
  folder_->write("twice.toml", text.replace(text.rfind("direction = \"z\""), 15, "direction = \"y\""));
  EXPECT_THAT(message("identify twice.toml -o no"), HasSubstr("second reference named 'y'"));
  text = study;
  folder_->write("vector.toml", text.replace(text.rfind("\"z\""), 3, "[0, 1, 1]"));
  EXPECT_THAT(message("identify vector.toml -o no"),
              HasSubstr("name is needed where the direction is a vector"));
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "no"));
}

TEST_F(References, BootstrapOfBothReferencesWritesItsTable) {
  const auto run = run_struna("identify study.toml -o boot --bootstrap 10", *folder_);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("bootstrap, 10 replicates"));
  const std::string csv = read_text(*folder_ / "boot/bootstrap.csv");
  EXPECT_EQ(csv.rfind("mode,natural_frequency [Hz]", 0), 0u);
}

}  // namespace
}  // namespace struna::tests
