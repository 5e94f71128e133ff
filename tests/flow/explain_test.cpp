// --tolerance and --explain through the program: what is chosen keeps what is asked, what is fixed stays and
// is told.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <complex>
#include <string>

#include "fem/body.hpp"
#include "fem/closed_forms.hpp"
#include "ident/transfer_function_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string open_scene = replaced(straight_wire_scene, "elements = 10\n", "");
const std::string simulated = R"([simulation]
duration = 0.05
excitation = { kind = "random", band = [10, 400], rms_acceleration = 5, seed = 1 }
)";

/// Largest error of the prediction against the closed form, relative on each line.
double error_of(const Folder& folder, const std::string& scene, const std::string& options) {
  folder.write("s.toml", scene);
  const ProgramRun run =
      run_struna("predict s.toml --band 10:500 --resolution 0.5 -o p.csv " + options, folder);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const fem::Section section = fem::solid_circle(0.0032);
  const fem::ClampedBeam beam{0.68, 120e9 * section.second_moment, 7650 * section.area};
  const auto tf = ident::read_transfer_function((folder / "p.csv").string());
  double worst = 0.0;
  for (long i = 0; i < tf.lines(); ++i) {
    const auto exact = fem::far_support_stiffness(beam, 0.02, tf.frequency_hz[i]);
    worst = std::max(worst, std::abs(tf.outputs[0].value[i] - exact) / std::abs(exact));
  }
  return worst;
}

TEST(Explain, APredictionKeepsTheToleranceAgainstTheClosedForm) {
  const Folder folder;
  for (const char* tolerance : {"0.01", "0.001", "0.0001"}) {
    const double error = error_of(folder, open_scene, std::string("--tolerance ") + tolerance);
    EXPECT_LT(error, std::stod(tolerance));
    EXPECT_GT(error, std::stod(tolerance) / 32.0)
        << "more than twice the elements needed";  // errors fall as n^-4
  }
  // The same in the scene; the option comes before it.
  const double of_scene = error_of(folder, "tolerance = 0.01\n" + open_scene, "");
  EXPECT_EQ(of_scene, error_of(folder, open_scene, "--tolerance 0.01"));
  EXPECT_EQ(of_scene, error_of(folder, "tolerance = 1e-4\n" + open_scene, "--tolerance 0.01"));
}

TEST(Explain, PredictTellsWhatWasChosenAndWhatMoreWouldCost) {
  const Folder folder;
  folder.write("s.toml", open_scene);
  const ProgramRun run = run_struna("predict s.toml --band 10:500 --explain -o p.csv", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("sized for outputs within 0.001"), HasSubstr("elements of 'wire'"),
                             HasSubstr("(chosen), error"), HasSubstr("less: "), HasSubstr("cost 2"),
                             HasSubstr("no contact in the scene"), HasSubstr("beam theory"),
                             HasSubstr("lines in the narrowest resonance"), Not(HasSubstr("OUTSIDE"))));
}

TEST(Explain, WhatIsFixedIsToldAsFixedAndFlaggedOutsideTheTolerance) {
  const Folder folder;
  folder.write("s.toml", straight_wire_scene);  // ten elements
  const ProgramRun run = run_struna(
      "predict s.toml --band 10:500 --resolution 0.5 --tolerance 0.001 --explain -o p.csv", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("elements of 'wire': 10 (fixed), error"),
                             HasSubstr("OUTSIDE the tolerance of 0.001"), HasSubstr("every 0.5 Hz (fixed)")));
  EXPECT_THAT(run.err, HasSubstr("tolerance 0.001; more elements than 10"));
}

TEST(Explain, EigenTakesAToleranceOfFrequencies) {
  const Folder folder;
  folder.write("s.toml", open_scene);
  const ProgramRun coarse = run_struna("eigen s.toml --band 0:500 --tolerance 1e-3 --explain", folder);
  const ProgramRun usual = run_struna("eigen s.toml --band 0:500 --explain", folder);
  ASSERT_EQ(coarse.exit_code, 0) << coarse.err;
  EXPECT_THAT(coarse.out, AllOf(HasSubstr("natural frequencies within 0.001 up to 500 Hz"),
                                HasSubstr("found on twice the elements"), Not(HasSubstr("OUTSIDE"))));
  EXPECT_THAT(usual.out, AllOf(HasSubstr("within 1e-05"), Not(HasSubstr("OUTSIDE"))));
}

TEST(Explain, SimulateTellsModesStepsPlanesAndTheory) {
  const Folder folder;
  folder.write("s.toml", open_scene + simulated);
  const ProgramRun run = run_struna("simulate s.toml --tolerance 0.01 --explain -o r.csv", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("sized for 0.01 of the largest displacement"), HasSubstr("follow statically"),
                    HasSubstr("(f_band/f)^2"), HasSubstr("time step"), HasSubstr("bending strain"),
                    HasSubstr("linear, holds"), HasSubstr("no contact")));
  // 4000 = 400/sqrt(0.01)
  EXPECT_THAT(run.out, HasSubstr("above 4000 Hz"));
  // Four times the motion stretches the wire 16 times as much, by 8 % of the Euler strain.
  folder.write("s.toml", open_scene + replaced(simulated, "rms_acceleration = 5", "rms_acceleration = 20"));
  const ProgramRun large = run_struna("simulate s.toml --explain -o r.csv", folder);
  ASSERT_EQ(large.exit_code, 0) << large.err;
  EXPECT_THAT(large.out, HasSubstr("linear, OUTSIDE its range"));
}

TEST(Explain, TolerancesThatCannotBeAreRefused) {
  const Folder folder;
  folder.write("s.toml", open_scene);
  for (const char* wrong : {"0", "1", "-0.1", "2", "nan"}) {
    const ProgramRun run = run_struna(std::string("eigen s.toml --tolerance ") + wrong, folder);
    EXPECT_EQ(run.exit_code, 2) << wrong;
    EXPECT_THAT(run.err, HasSubstr("--tolerance: must lie between 0 and 1"));
  }
  folder.write("s.toml", "tolerance = 1.5\n" + open_scene);
  const ProgramRun run = run_struna("eigen s.toml", folder);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("struna: s.toml:1: tolerance is a fraction, below 1, got 1.5"));
}

}  // namespace
}  // namespace struna::tests
