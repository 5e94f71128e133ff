// What the program warns of and goes on: measurements and scenes that are possible, but seldom meant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <memory>
#include <numbers>
#include <random>

#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using std::numbers::pi;
using testing::HasSubstr;
using testing::Not;

constexpr double sample_rate = 1000.0;

/// A record of a spring of 2 N/m under a given motion, with noise of `noise` N.
std::string record(long rows, const std::function<double(long)>& motion, double noise = 1e-3) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  std::string text = "time [s],displacement [m],force_y [N]\n";
  char row[120];
  for (long i = 0; i < rows; ++i) {
    const double x = motion(i);
    std::snprintf(row, sizeof row, "%.4f,%.9g,%.9g\n", static_cast<double>(i) / sample_rate, x,
                  2.0 * x + noise * normal(random));
    text += row;
  }
  return text;
}

std::function<double(long)> noise(unsigned seed) {
  const auto random = std::make_shared<std::mt19937_64>(seed);
  return [random](long) { return std::normal_distribution<double>()(*random); };
}

double hit(long i) {
  return i >= 100 && i < 110 ? std::sin(pi * static_cast<double>(i - 100) / 10.0) : 0.0;
}

ProgramRun frf(const Folder& folder, const std::string& content, const std::string& options = "") {
  folder.write("a.csv", content);
  ProgramRun run =
      run_struna("frf a.csv --input displacement --output force_y -o out.csv --quiet " + options, folder);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run;
}

TEST(Warnings, SoundRecordsHaveNone) {
  const Folder folder;
  EXPECT_EQ(frf(folder, record(20000, noise(1)), "--estimator h1").err, "");
}

TEST(Warnings, ChannelsThatAreClippedAreNamed) {
  const Folder folder;
  const auto sound = noise(2);
  const ProgramRun run = frf(folder, record(20000, [&](long i) { return std::min(sound(i), 2.0); }));
  EXPECT_THAT(run.err, HasSubstr("warning: a.csv: "));
  EXPECT_THAT(run.err, HasSubstr("samples of 'displacement' stand at its largest value, 2 m: clipped?"));
  EXPECT_THAT(run.err, Not(HasSubstr("'force_y' stand")));
}

TEST(Warnings, AHammerWithoutImpactIsSuggestedIt) {
  const Folder folder;
  EXPECT_THAT(frf(folder, record(4000, hit), "--estimator h1").err, HasSubstr("use --impact"));
  EXPECT_THAT(frf(folder, record(4000, hit), "--impact --estimator h1").err, Not(HasSubstr("use --impact")));
}

TEST(Warnings, OneAverageAndABandBeyondTheLinesAreTold) {
  const Folder folder;
  const std::string content = record(4000, noise(3));
  EXPECT_THAT(frf(folder, content, "--estimator h1 --window rectangular").err, HasSubstr("one average only"));
  EXPECT_THAT(frf(folder, content, "--estimator h1 --band 10:900").err,
              HasSubstr("the band up to 900 Hz ends at 49"));
  EXPECT_THAT(frf(folder, content, "--estimator h1 --band 10:490").err, Not(HasSubstr("the band up to")));
}

TEST(Warnings, LinesWithoutInputPowerAreLeftOut) {
  // Four periods of 500 samples in one segment: every fourth line, of 500 Hz / 0.5 Hz, has power.
  const Folder folder;
  std::vector<double> period(500);
  const auto random = noise(4);
  for (double& x : period) x = random(0);
  frf(folder, record(2000, [&](long i) { return period[static_cast<std::size_t>(i % 500)]; }),
      "--estimator h1 --window rectangular --resolution 0.5");
  const std::string lines = read_text(folder / "out.csv");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 250);  // the header and 2, 4 … 498 Hz
  EXPECT_THAT(lines, HasSubstr("\n2,"));
  EXPECT_THAT(lines, Not(HasSubstr("\n2.5,")));
}

/// Receptance of one mode at 100 Hz, loss factor 0.05, with the imaginary part times `sign`.
std::string one_mode(double sign) {
  std::string text = "frequency [Hz],x_re [m/N],x_im [m/N]\n";
  char row[120];
  for (double f = 60.0; f <= 140.0; f += 0.25) {
    const std::complex<double> h = 1.0 / (1e4 - f * f + std::complex<double>(0.0, 0.05 * 1e4));
    std::snprintf(row, sizeof row, "%.4f,%.9g,%.9g\n", f, h.real(), sign * h.imag());
    text += row;
  }
  return text;
}

TEST(Warnings, NoModeIsExplained) {
  const Folder folder;
  folder.write("sound.csv", one_mode(1.0));
  folder.write("conjugate.csv", one_mode(-1.0));
  EXPECT_THAT(run_struna("modes sound.csv -o m.csv", folder).err, Not(HasSubstr("no mode")));
  const ProgramRun run = run_struna("modes conjugate.csv -o m.csv", folder);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err,
              HasSubstr("warning: conjugate.csv: no mode, but 1 with the sign of the imaginary parts"));
}

TEST(Warnings, ASceneInMillimetresIsTold) {
  const Folder folder;
  std::string scene = read_text(sample_data("straight_wire/scene.toml"));
  folder.write("m.toml", scene);
  EXPECT_EQ(run_struna("eigen m.toml --modes 1 --quiet", folder).err, "");
  const std::size_t at = scene.find("diameter = ");
  ASSERT_NE(at, std::string::npos);
  folder.write("mm.toml", scene.replace(at, scene.find('\n', at) - at, "diameter = 3.2"));
  const ProgramRun run = run_struna("eigen mm.toml --modes 1 --quiet", folder);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("warning: mm.toml: body 'wire' is 0.68 m long and 3.2 m thick"));
}

}  // namespace
}  // namespace struna::tests
