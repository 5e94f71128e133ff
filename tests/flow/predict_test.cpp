// The model's commands, `predict` and `eigen`, and what `fit`, `identify` and `compare` say of it, through
// the program itself: the straight wire against its closed forms, the options, the warnings.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "fem/body.hpp"
#include "fem/closed_forms.hpp"
#include "ident/csv.hpp"
#include "ident/transfer_function_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using Complex = std::complex<double>;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string scene = replaced(replaced(straight_wire_scene, "[\"y\"]", "[\"x\", \"y\", \"z\"]"),
                                   "elements = 10", "elements = 28");

/// The scene's wire as the closed forms take it.
fem::ClampedBeam beam() {
  const fem::Section section = fem::solid_circle(0.0032);
  return {0.68, 120e9 * section.second_moment, 7650 * section.area};
}

ident::TransferFunction predicted(const Folder& folder, const std::string& text, const std::string& options) {
  folder.write("s.toml", text);
  const ProgramRun run = run_struna("predict s.toml -o p.csv " + options, folder);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return ident::read_transfer_function((folder / "p.csv").string());
}

/// Largest deviation of the y output from a closed form, relative at each line.
template <class ClosedForm>
double deviation(const ident::TransferFunction& tf, ClosedForm closed_form) {
  double worst = 0.0;
  for (long i = 0; i < tf.lines(); ++i) {
    const Complex expected = closed_form(tf.frequency_hz[i]);
    worst = std::max(worst, std::abs(tf.outputs.at(1).value[i] - expected) / std::abs(expected));
  }
  return worst;
}

TEST(Predict, StraightWireMeetsTheClosedForm) {
  const Folder folder;
  const auto far = [](double f) { return fem::far_support_stiffness(beam(), 0.02, f); };
  const auto tf = predicted(folder, scene, "--band 10:500 --resolution 0.5");
  ASSERT_EQ(tf.lines(), 981);
  EXPECT_EQ(tf.outputs[1].name, "force_y");
  EXPECT_EQ(tf.outputs[1].unit, "N/m");
  // Discretisation: the mesh shifts the mode at 455 Hz by 1.9e-4, a resonance magnifies twice that by 1/eta.
  const double coarse = deviation(tf, far);
  EXPECT_LT(coarse, 0.025);
  EXPECT_GT(coarse, 0.005);  // the elements of the scene, not more
  // Chosen by the program: 1e-5 of the frequencies, likewise magnified by 2/eta.
  const auto fine =
      predicted(folder, replaced(scene, "elements = 28\n", ""), "--band 10:500 --resolution 0.5");
  EXPECT_LT(deviation(fine, far), 1.5e-3);
  for (const int across : {0, 2}) {
    // Rounding: shaken in one plane, the wire has no cause to move in the other.
    EXPECT_LT(tf.outputs[across].value.cwiseAbs().maxCoeff(),
              1e-9 * tf.outputs[1].value.cwiseAbs().maxCoeff());
  }
}

TEST(Predict, ViscousDampingMeetsTheClosedFormOfBothSupportsShaken) {
  const Folder folder;
  std::string text = replaced(scene, "loss_factor = 0.02", "rayleigh = { alpha = 3, beta = 1e-5 }");
  text = replaced(text, "elements = 28\n", "");
  text = replaced(text, "direction = \"y\"", "direction = \"y\"\nalso = [\"wire.end\"]");
  const auto tf = predicted(folder, text, "--damping viscous --band 10:500 --resolution 2");
  const auto half_of_both = [](double f) {
    const double omega = 2.0 * std::numbers::pi * f;
    return 0.5 *
           fem::both_supports_stiffness(beam(), Complex(1.0, 1e-5 * omega), Complex(1.0, -3.0 / omega), f);
  };
  // Discretisation, as above: at least 1 % of damping; antiresonances of the sum magnify as much.
  EXPECT_LT(deviation(tf, half_of_both), 3e-3);
}

TEST(Predict, LikeRepeatsOutputsFormAndLines) {
  const Folder folder;
  folder.write("like.csv",
               "frequency [Hz],force_z_re [kg],force_z_im [kg],force_y_re [kg],force_y_im [kg]\n"
               "17,1,0,1,0\n40.5,1,0,1,0\n41,1,0,1,0\n300,1,0,1,0\n");
  const auto tf = predicted(folder, scene, "--like like.csv");
  ASSERT_EQ(tf.outputs.size(), 2U);
  EXPECT_EQ(tf.outputs[0].name, "force_z");
  EXPECT_EQ(tf.outputs[1].name, "force_y");
  EXPECT_EQ(tf.outputs[1].kind, ident::FrfKind::apparent_mass);
  ASSERT_EQ(tf.lines(), 4);
  EXPECT_EQ(tf.frequency_hz, Eigen::Vector4d(17, 40.5, 41, 300));
  EXPECT_LT(deviation(tf,
                      [](double f) {
                        const double omega = 2.0 * std::numbers::pi * f;
                        return -fem::far_support_stiffness(beam(), 0.02, f) / (omega * omega);
                      }),
            2e-3);  // discretisation: 1e-4 of the frequency at 326 Hz, off resonance
  const auto part = predicted(folder, scene, "--like like.csv --band 40:100");
  EXPECT_EQ(part.frequency_hz, Eigen::Vector2d(40.5, 41));
}

/// The wire along so many points about a bend of 0.2 rad in its middle.
std::string bent_scene(int points) {
  std::string text;
  for (int i = 0; i < points; ++i) {
    const double s = 0.68 * i / (points - 1), beyond = std::max(0.0, s - 0.34);
    text += fmt::format("{}[{:.5f}, {:.5f}, 0]", i > 0 ? ", " : "", s - beyond * (1.0 - std::cos(0.2)),
                        beyond * std::sin(0.2));
  }
  return replaced(scene, "[[0,0,0], [0.68,0,0]]", "[" + text + "]");
}

TEST(Predict, TellsWhatItsCurveLeavesOpenAndWarnsWhereThatIsLikely) {
  const Folder folder;
  const auto run = [&](int points) {
    folder.write("bent.toml", bent_scene(points));
    return run_struna("predict bent.toml --band 10:90 --resolution 7.3 -o p.csv", folder);
  };
  const ProgramRun told = run(16), warned = run(12);
  EXPECT_THAT(told.out,
              HasSubstr("curve through 16 points that scatter by 0 m: natural frequencies within 1."));
  EXPECT_EQ(told.err, "");
  EXPECT_THAT(warned.err, HasSubstr("bent.toml:3: body.points of body 'wire' leave open how the curve runs"));
}

TEST(Predict, TellsWhatThePredictionLeavesOutOrLacks) {
  const Folder folder;
  const std::string rayleigh = replaced(scene, "loss_factor = 0.02", "rayleigh = { alpha = 3, beta = 1e-5 }");
  folder.write("structural.toml", scene);
  folder.write("viscous.toml", rayleigh);
  const std::string lines = " --band 10:90 --resolution 7.3 -o p.csv";
  const auto warnings = [&](const std::string& arguments) {
    const ProgramRun run = run_struna("predict " + arguments + lines, folder);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err;
  };
  EXPECT_EQ(warnings("structural.toml"), "");
  EXPECT_EQ(warnings("viscous.toml --damping viscous"), "");
  EXPECT_THAT(warnings("viscous.toml"),
              HasSubstr("no loss factor: the prediction with structural damping is undamped"));
  EXPECT_THAT(warnings("structural.toml --damping viscous"),
              HasSubstr("no rayleigh coefficients: the prediction with viscous damping is undamped"));
  EXPECT_THAT(warnings("'" + sample_data("wire_in_band/scene.toml").string() + "' --damping viscous"),
              HasSubstr("contact is left out"));
  folder.write(
      "contradicted.toml",
      "body = \"wire\"\n[rayleigh]\nalpha = 3\nbeta = 1e-5\nrms = 7\nmisfit = 0.12\nchance = 1e-9\n");
  EXPECT_THAT(warnings("viscous.toml --damping viscous --parameters contradicted.toml"),
              HasSubstr("Rayleigh coefficients of body 'wire': contradicted"));
  folder.write("coarse.toml", replaced(scene, "elements = 28", "elements = 3"));
  EXPECT_THAT(warnings("coarse.toml"), HasSubstr("more elements than 3"));
}

TEST(Predict, TellsOfAnExponentialWindowThatAPredictionDoesNotHave) {
  const Folder folder;
  folder.write("s.toml", scene);
  folder.write("like.csv",
               "frequency [Hz],force_y_re [N/m],force_y_im [N/m],exponential_decay [1/s]\n"
               "20,-50,1,4\n21,-60,1,4\n22,-80,2,4\n");
  const char* told = "an exponential window adds 4 1/s to the decay of every measured mode";
  const ProgramRun predict = run_struna("predict s.toml --like like.csv -o p.csv", folder);
  EXPECT_EQ(predict.exit_code, 0);
  EXPECT_THAT(predict.err, HasSubstr(told));
  EXPECT_THAT(run_struna("compare like.csv p.csv", folder).err, HasSubstr(told));
  EXPECT_EQ(run_struna("compare like.csv like.csv", folder).err, "");
}

/// Columns of a CSV file, by the beginnings of their names.
std::vector<std::vector<double>> columns(const std::string& file, const std::vector<std::string>& names) {
  ident::CsvReader csv(file);
  std::vector<std::vector<double>> columns(names.size());
  std::vector<std::string_view> fields;
  while (csv.next(fields)) {
    for (std::size_t k = 0; k < names.size(); ++k)
      columns[k].push_back(csv.number(fields, csv.column(names[k])));
  }
  return columns;
}

TEST(Eigen, StraightWireHasEachFrequencyOncePerPlaneAndConstantsInThePlaneOfTheDrive) {
  const Folder folder;
  folder.write("s.toml", scene);
  ASSERT_EQ(run_struna("eigen s.toml --modes 8 -o e.csv", folder).exit_code, 0);
  const auto c = columns((folder / "e.csv").string(), {"mode", "natural_frequency", "force_x_modal_constant",
                                                       "force_y_modal_constant", "force_z_modal_constant"});
  ASSERT_EQ(c[0].size(), 8U);
  for (int r = 0; r < 8; r += 2) {
    const double f = fem::natural_frequency_hz(beam(), r / 2 + 1);
    double largest = 0.0, smallest = INFINITY;
    for (int i = r; i < r + 2; ++i) {
      EXPECT_EQ(c[0][i], i + 1);
      EXPECT_NEAR(c[1][i], f, 5e-5 * f);  // discretisation, 4.5e-5 at the fourth
      largest = std::max(largest, std::abs(c[3][i]));
      smallest = std::min(smallest, std::abs(c[3][i]));
      // Rounding: the planes are solved apart.
      EXPECT_LT(std::max(std::abs(c[2][i]), std::abs(c[4][i])), 1e-9 * 169.0);
    }
    EXPECT_LT(smallest, 1e-9 * largest);
    // Near its resonance the closed form is that mode: H(f_r) = -w^2 (C/w^2)(1 + i eta)/(i eta), to the
    // other modes' share, some eta.
    const double omega2 = std::pow(2.0 * std::numbers::pi * f, 2);
    EXPECT_NEAR(std::abs(fem::far_support_stiffness(beam(), 0.002, f)) * 0.002 / omega2, largest / omega2,
                0.01 * largest / omega2);
  }
}

TEST(Eigen, ListsTheModesOfABandWithTheirNumbersOrTellsWhichAreNextToIt) {
  const Folder folder;
  folder.write("s.toml", scene);
  ASSERT_EQ(run_struna("eigen s.toml --band 60:140 -o e.csv", folder).exit_code, 0);
  EXPECT_EQ(columns((folder / "e.csv").string(), {"mode"})[0], (std::vector<double>{3, 4, 5, 6}));
  const auto fault = [&](const std::string& options) {
    const ProgramRun run = run_struna("eigen s.toml -o none.csv " + options, folder);
    EXPECT_EQ(run.exit_code, 1) << options;
    EXPECT_FALSE(std::filesystem::exists(folder / "none.csv")) << options;
    return run.err;
  };
  EXPECT_THAT(fault("--band 30:60"), HasSubstr("next to it: mode 2 at 24.3996 Hz, mode 3 at 67.2586 Hz"));
  EXPECT_THAT(fault("--band 1:2"), HasSubstr("next to it: mode 1 at 24.3996 Hz"));
  EXPECT_THAT(fault("--modes 200"), HasSubstr("--modes 200: the 28 elements of body 'wire' have 162 modes"));
  EXPECT_THAT(fault("--band 10:1e6"), HasSubstr("end at mode 162"));
}

TEST(Eigen, NeedsNoLinearPath) {
  const Folder folder;
  const std::string band = R"([[body]]
name = "band"
points = [[0.1, 0, 0], [0.5, 0, 0]]
diameter = 0.008
density = 4535
[body.material]
youngs_modulus = 60e9
)";
  folder.write("s.toml", band + replaced(scene, "support = \"wire.end\"", "support = \"band.end\""));
  for (const char* body : {"wire", "band"}) {
    const ProgramRun run = run_struna(std::string("eigen s.toml --modes 3 --body ") + body, folder);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, Not(HasSubstr("C force")));
  }
  EXPECT_THAT(run_struna("eigen s.toml --modes 3", folder).err, HasSubstr("choose with --body"));
  folder.write("s.toml", band + scene);
  EXPECT_THAT(run_struna("eigen s.toml --modes 3", folder).out, StartsWith("body wire, "));
}

TEST(Fit, NumbersTheModelsModesAsEigenDoes) {
  // Free at both ends: six rigid modes come first.
  const Folder folder;
  std::string text = replaced(scene, "[[0,0,0], [0.68,0,0]]", "[[0, 0, 0], [0.2, 0.1, 0], [0.4, 0.05, 0.1]]");
  text = replaced(text, "elements = 28\n", "elements = 28\nstart = \"free\"\nend = \"free\"\n");
  text = replaced(text, "support = \"wire.start\"\ndirection = \"y\"",
                  "point = \"wire@0\"\ndirection = [1, 2, 3]");
  text = replaced(text, "support = \"wire.end\"", "point = \"wire@0.1\"");
  folder.write("s.toml", text);
  ASSERT_EQ(run_struna("eigen s.toml --modes 13 -o e.csv", folder).exit_code, 0);
  const auto eigen = columns((folder / "e.csv").string(), {"mode", "natural_frequency"});
  std::string modes = "natural_frequency [Hz],loss_factor [-]\n";
  for (int i = 0; i < 13; ++i) {
    if (i < 6) {
      EXPECT_EQ(eigen[1][i], 0.0) << i;
    }
    // The ninth is missing; the tenth and eleventh, 0.1 Hz apart, appear as one.
    if (i >= 6 && i != 8 && i != 9) modes += std::to_string(eigen[1][i]) + ",0.02\n";
  }
  folder.write("m.csv", modes);
  const ProgramRun run = run_struna("fit s.toml m.csv -o id.toml --modulus-range 1e11:1.5e11", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("not measured: 9\n"));
  const std::string pairs = read_text(folder / "id.toml");
  const std::vector<std::string> numbers = {"7", "8", "10, 11", "12", "13"};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_THAT(pairs, HasSubstr("mode = " + std::to_string(i + 1) + "\nmodel = [" + numbers[i] + "]"));
  }
}

TEST(Fit, BlamesTheSceneAndTheOptionThatAreAtFault) {
  const Folder folder;
  folder.write("m.csv", "natural_frequency [Hz],loss_factor [-]\n24.4,0.02\n");
  folder.write("s.toml", scene.substr(0, scene.find("[measure]")));
  const ProgramRun run = run_struna("fit s.toml m.csv -o id.toml", folder);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, StartsWith("struna: s.toml: the scene needs a [measure]"));
  folder.write("s.toml", scene);
  for (const char* option : {"--modulus-law", "--loss-factor-law"}) {
    for (const char* law : {"table", "cubic"}) {
      const ProgramRun wrong =
          run_struna(std::string("fit s.toml m.csv -o id.toml ") + option + " " + law, folder);
      EXPECT_EQ(wrong.exit_code, 2);
      EXPECT_THAT(wrong.err, StartsWith(std::string("struna: ") + option + ": constant, power"));
    }
  }
}

TEST(Identify, TellsWhenNoModeIsTrustedForItsDamping) {
  // Hann segments with lines every 8 Hz: too few in every half-power band for a loss factor.
  const Folder folder;
  std::string study = read_text(sample_data("wire_in_band/study.toml"));
  study = replaced(study, "resolution = 0.35", "estimator = \"welch\"\nresolution = 8.0");
  for (const char* name : {"bare_scene.toml", "bare.csv"})
    study =
        replaced(study, std::string("\"") + name, "\"" + sample_data("wire_in_band").string() + "/" + name);
  folder.write("study.toml", study);
  const ProgramRun run = run_struna("identify study.toml -o out", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("loss factor: no mode is trusted for it\n"));
  EXPECT_THAT(run.out, HasSubstr("Rayleigh: no mode is trusted for its damping\n"));
  EXPECT_THAT(run.err, HasSubstr("no loss factor: the prediction with structural damping is undamped"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/report.html"));
}

}  // namespace
}  // namespace struna::tests
