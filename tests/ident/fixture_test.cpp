#include "ident/fixture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using ::testing::HasSubstr;
using tests::message_of;
using Complex = std::complex<double>;

TransferFunction function_of(FrfKind kind, const Eigen::VectorXd& frequency_hz,
                             const std::string& name = "force") {
  TransferFunction tf;
  tf.frequency_hz = frequency_hz;
  TransferFunction::Output output;
  output.name = name;
  output.kind = kind;
  output.unit = unit_of(kind);
  output.value = Eigen::VectorXcd::LinSpaced(frequency_hz.size(), Complex(1.0, 2.0), Complex(3.0, -1.0));
  output.sigma = Eigen::VectorXd::Constant(frequency_hz.size(), 0.3);
  tf.outputs.push_back(output);
  return tf;
}

const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(11, 10.0, 60.0);

TEST(Fixture, AMassIsTheSameInEveryForm) {
  const double mass = 0.25;
  const TransferFunction apparent = function_of(FrfKind::apparent_mass, lines);
  const TransferFunction less = without_mass(apparent, {{"force", mass}});
  EXPECT_TRUE(less.outputs[0].value.isApprox((apparent.outputs[0].value.array() - mass).matrix()));
  for (const FrfKind kind : {FrfKind::dynamic_stiffness, FrfKind::impedance}) {
    const TransferFunction other = without_mass(convert(apparent, kind), {{"force", mass}});
    EXPECT_TRUE(
        convert(other, FrfKind::apparent_mass).outputs[0].value.isApprox(less.outputs[0].value, 1e-12));
    EXPECT_EQ(other.outputs[0].sigma, convert(apparent, kind).outputs[0].sigma);
  }
}

TEST(Fixture, AnEmptyRunIsTakenOutBetweenItsLinesAndAddsItsNoise) {
  // A mass on a spring, measured as a stiffness on coarser lines than the apparent mass that it is taken out
  // of.
  const Eigen::VectorXd coarse = Eigen::VectorXd::LinSpaced(501, 5.0, 80.0);
  TransferFunction empty = function_of(FrfKind::apparent_mass, coarse);
  const auto fixture = [](double f) { return Complex(0.02, 0.001) / (1.0 - std::pow(f / 400.0, 2.0)); };
  for (long i = 0; i < coarse.size(); ++i) empty.outputs[0].value[i] = fixture(coarse[i]);
  empty.outputs[0].sigma.setConstant(0.4);
  const TransferFunction full = function_of(FrfKind::apparent_mass, lines);
  for (const FrfKind kind : {FrfKind::apparent_mass, FrfKind::dynamic_stiffness}) {
    const TransferFunction less = without_fixture(full, convert(empty, kind));
    for (long i = 0; i < lines.size(); ++i) {
      EXPECT_NEAR(std::abs(less.outputs[0].value[i] - (full.outputs[0].value[i] - fixture(lines[i]))), 0.0,
                  1e-6);
      EXPECT_NEAR(less.outputs[0].sigma[i], 0.5, 1e-9);
    }
  }
}

TEST(Fixture, AnEmptyRunsLineAtZeroIsLeftOut) {
  const TransferFunction full = function_of(FrfKind::dynamic_stiffness, lines);
  const TransferFunction empty =
      function_of(FrfKind::dynamic_stiffness, Eigen::VectorXd::LinSpaced(7, 0.0, 60.0));
  EXPECT_TRUE(without_fixture(full, empty).outputs[0].value.allFinite());
  EXPECT_THROW(without_fixture(full, restrict_band(empty, 0.0, 10.0)), Error);
}

TEST(Fixture, OutputsThatTheEmptyRunLacksStay) {
  TransferFunction full = function_of(FrfKind::apparent_mass, lines);
  full.outputs.push_back(function_of(FrfKind::apparent_mass, lines, "other").outputs[0]);
  full.outputs[1].coherence = Eigen::VectorXd::Constant(lines.size(), 0.9);
  const TransferFunction less = without_fixture(full, function_of(FrfKind::apparent_mass, lines));
  EXPECT_LT(less.outputs[0].value.norm(), 1e-12);
  EXPECT_EQ(less.outputs[1].value, full.outputs[1].value);
  EXPECT_EQ(less.outputs[1].coherence.size(), lines.size());
}

TEST(Fixture, RefusesWhatHasNoMass) {
  const TransferFunction force = function_of(FrfKind::apparent_mass, lines);
  const TransferFunction motion = function_of(FrfKind::receptance, lines);
  EXPECT_THAT(message_of([&] {
                without_mass(motion, {{"force", 1.0}});
              }),
              HasSubstr("force over motion only"));
  EXPECT_THAT(message_of([&] { without_mass(force, {{"forec", 1.0}}); }), HasSubstr("no such output"));
  EXPECT_THAT(message_of([&] { without_mass(force, {{"force", -1.0}}); }), HasSubstr("not negative"));
  EXPECT_THAT(message_of([&] { without_fixture(force, restrict_band(force, 20.0, 50.0)); }),
              HasSubstr("from 20 to 50 Hz"));
  EXPECT_THAT(message_of([&] { without_fixture(force, function_of(FrfKind::apparent_mass, lines, "f")); }),
              HasSubstr("none of the outputs"));
  EXPECT_THAT(message_of([&] { without_fixture(force, motion); }), HasSubstr("force over motion only"));
}

}  // namespace
}  // namespace struna::ident
