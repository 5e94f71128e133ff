#include "ident/parameter_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "fem/error.hpp"
#include "ident/rayleigh_flag.hpp"

namespace struna::ident {
namespace {

using fem::FrequencyLaw;
using Kind = FrequencyLaw::Kind;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class ParameterFile : public ::testing::Test {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(file) << text;
    return file;
  }
  std::string error_of(const std::string& text) const {
    write(text);
    try {
      read_parameters(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }
  void TearDown() override { std::filesystem::remove(file); }

  // One file per test, as tests run side by side.
  const std::string file = (std::filesystem::temp_directory_path() /
                            (std::string("struna_parameters_") +
                             ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml"))
                               .string();
};

LawFit law(Kind kind, std::vector<double> parameters, std::vector<double> knots = {},
           std::vector<double> value = {}) {
  LawFit fit;
  fit.law = {kind, std::move(parameters), std::move(knots), std::move(value), 16.8, 858.0};
  fit.parameter_sigma = Eigen::VectorXd::Constant(2, 1.0 / 3.0);
  fit.aicc = 12.3456789012345678;
  fit.rms = 0.1;
  return fit;
}

IdentifiedParameters sample() {
  IdentifiedParameters p;
  p.body = "wire \"two\"";
  p.rayleigh.rayleigh = {43.1, 2.0 / 3.0 * 1e-6};
  p.rayleigh.alpha_sigma = 0.1 + 0.2;  // a number with an ugly tail
  p.rayleigh.beta_sigma = 1e-300;
  p.rayleigh.determined = true;
  p.rayleigh_known = true;
  p.modulus.frequency_hz = Eigen::VectorXd{{16.8, 42.4, 858.0}};
  p.modulus.value = Eigen::VectorXd{{1e11, 1e11 / 3.0, std::nextafter(1.06e11, 2e11)}};
  p.modulus.sigma = Eigen::VectorXd{{1e8, 2e8, 3e8 / 7.0}};
  p.modulus.laws = {law(Kind::power, {1.02e11, 0.02, 100.0}), law(Kind::constant, {1e11})};
  p.loss_factor.frequency_hz = Eigen::VectorXd{{42.4, 858.0}};
  p.loss_factor.value = Eigen::VectorXd{{0.037, 0.0371}};
  p.loss_factor.sigma = Eigen::VectorXd{{1e-3, 1e-4}};
  p.loss_factor.laws = {
      law(Kind::monotone_spline, {}, {42.4, 100.0 / 3.0 * 10.0, 858.0}, {0.037, 0.0372, 0.0371})};
  p.kramers_kronig_loss_factor = Eigen::VectorXd{{0.03, 0.03}};
  p.rejected = {{316.7, "ambiguous: model mode 10 or 11", LeftOutOf::both},
                {430.0, "loss factor: close_modes", LeftOutOf::loss_factor}};
  p.pairing.pairs = {{0, {0}, 0.99, 1e11, 1e8}, {2, {13, 14}, std::nan(""), 1e11, 1e8}};
  p.provenance = {"0.1.0", "2026-01-01T00:00:00Z", {{"modes.csv", "ab12"}}, 10.0, 1000.0};
  return p;
}

void expect_same(const IdentifiedCurve& read, const IdentifiedCurve& written) {
  EXPECT_EQ(read.frequency_hz, written.frequency_hz);
  EXPECT_EQ(read.value, written.value);
  EXPECT_EQ(read.sigma, written.sigma);
  ASSERT_EQ(read.laws.size(), written.laws.size());
  EXPECT_EQ(read.laws.back().law.kind, written.laws.back().law.kind);
  EXPECT_EQ(read.laws.back().law.parameters, written.laws.back().law.parameters);
  const LawFit& a = read.laws.front();
  const LawFit& b = written.laws.front();
  EXPECT_EQ(a.law.kind, b.law.kind);
  EXPECT_EQ(a.law.parameters, b.law.parameters);
  EXPECT_EQ(a.law.frequency, b.law.frequency);
  EXPECT_EQ(a.law.value, b.law.value);
  EXPECT_EQ(a.law.valid_from_hz, b.law.valid_from_hz);
  EXPECT_EQ(a.law.valid_to_hz, b.law.valid_to_hz);
  EXPECT_EQ(a.parameter_sigma, b.parameter_sigma);
  EXPECT_EQ(a.aicc, b.aicc);
}

TEST_F(ParameterFile, RoundTripsToTheLastBit) {
  const IdentifiedParameters written = sample();
  write_parameters(written, file);
  const IdentifiedParameters read = read_parameters(file);
  EXPECT_EQ(read.body, written.body);
  EXPECT_TRUE(read.rayleigh_known);
  EXPECT_EQ(read.rayleigh.rayleigh.alpha, written.rayleigh.rayleigh.alpha);
  EXPECT_EQ(read.rayleigh.rayleigh.beta, written.rayleigh.rayleigh.beta);
  EXPECT_EQ(read.rayleigh.alpha_sigma, written.rayleigh.alpha_sigma);
  EXPECT_EQ(read.rayleigh.beta_sigma, written.rayleigh.beta_sigma);
  expect_same(read.modulus, written.modulus);
  expect_same(read.loss_factor, written.loss_factor);
}

TEST_F(ParameterFile, DoubtsAreWrittenAndDoNotDisturb) {
  Doubt offset;
  offset.kind = DoubtKind::level_offset;
  offset.count = 14;
  offset.value = 1000.0;
  write_parameters(sample(), file, {offset});
  std::ifstream in(file);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  EXPECT_THAT(text, HasSubstr("# This result is doubted"));
  EXPECT_THAT(text, HasSubstr("[[doubt]]\nkind = \"level_offset\"\ntext = "));
  EXPECT_THAT(text, HasSubstr("mm taken for m"));
  EXPECT_THAT(text, HasSubstr("  # noise alone"));
  expect_same(read_parameters(file).modulus, sample().modulus);
}

TEST_F(ParameterFile, ModesWithoutTrustLeaveTheLaws) {
  IdentifiedParameters doubted = sample();
  withdraw_trust(doubted);
  write_parameters(doubted, file);
  const IdentifiedParameters read = read_parameters(file);
  EXPECT_EQ(read.modulus.value.size(), 0);
  EXPECT_EQ(read.modulus.laws.front().law.parameters, sample().modulus.laws.front().law.parameters);
}

TEST(LawText, NamesParametersWithErrorsAndUnits) {
  LawFit power;
  power.law = {Kind::power, {1.02e11, 0.02, 100.0}, {}, {}, 0.0, 0.0};
  power.parameter_sigma = Eigen::VectorXd{{1e8, 3e-4, 0.0}};
  EXPECT_EQ(law_text(power, "Pa"),
            "value 1.02e+11 +- 1e+08 Pa, exponent 0.02 +- 0.0003, reference_frequency 100 Hz");
  LawFit knots;
  knots.law = {Kind::monotone_spline, {}, {10.0, 100.0}, {0.02, 0.03}, 0.0, 0.0};
  EXPECT_EQ(law_text(knots, ""), "0.02 at 10 Hz, 0.03 at 100 Hz");
}

TEST_F(ParameterFile, EveryKindOfLawRoundTrips) {
  for (const LawFit& fit : {law(Kind::constant, {1e11}), law(Kind::power, {1e11, -0.01, 50.0}),
                            law(Kind::fractional_zener, {9e10, 1.3, 200.0, 0.5}),
                            law(Kind::monotone_spline, {}, {10.0, 20.0}, {1e11, 2e11}),
                            law(Kind::table, {}, {10.0, 20.0, 30.0}, {1e11, 2e11, 1.5e11})}) {
    IdentifiedParameters written = sample();
    written.modulus.laws = {fit};
    write_parameters(written, file);
    expect_same(read_parameters(file).modulus, written.modulus);
  }
}

TEST_F(ParameterFile, InfinityAndUnknownDampingSurvive) {
  IdentifiedParameters written = sample();
  written.rayleigh.alpha_sigma = std::numeric_limits<double>::infinity();
  written.rayleigh.determined = false;
  write_parameters(written, file);
  EXPECT_TRUE(std::isinf(read_parameters(file).rayleigh.alpha_sigma));
  EXPECT_FALSE(read_parameters(file).rayleigh.determined);
  written.rayleigh_known = false;
  written.loss_factor = {};
  write_parameters(written, file);
  const IdentifiedParameters read = read_parameters(file);
  EXPECT_FALSE(read.rayleigh_known);
  EXPECT_TRUE(read.loss_factor.laws.empty());
}

TEST_F(ParameterFile, RayleighsFlagIsReadAgain) {
  IdentifiedParameters written = sample();
  written.rayleigh.rms = 7.0;
  written.rayleigh.misfit = 0.12;
  written.rayleigh.chance = 1e-9;
  write_parameters(written, file);
  EXPECT_THAT(caveat(read_parameters(file).rayleigh),
              HasSubstr("contradicted: the modes' damping lies 12 % off"));
  const IdentifiedParameters by_hand =
      read_parameters(write("body = \"wire\"\n[rayleigh]\nalpha = 1\nbeta = 0\n"));
  EXPECT_EQ(caveat(by_hand.rayleigh), "");
}

TEST_F(ParameterFile, AHandWrittenFileWorks) {
  const IdentifiedParameters p = read_parameters(write(R"(
body = "band"
[modulus.law]
kind = "constant"
value = 60e9
[loss_factor.law]
kind = "table"
frequency = [10, 1000]   # integers are numbers too
value = [0, 0.05]
)"));
  EXPECT_EQ(p.body, "band");
  EXPECT_EQ(p.modulus.laws.at(0).law.at(77.0), 60e9);
  EXPECT_EQ(p.loss_factor.laws.at(0).law.at(1000.0), 0.05);
  EXPECT_FALSE(p.rayleigh_known);
  fem::Material material;
  material.youngs_modulus = fem::constant_law(1.0);
  material.rayleigh = {5.0, 0.0};
  const fem::Material applied = apply(p, material);
  EXPECT_EQ(applied.youngs_modulus.at(10.0), 60e9);
  EXPECT_EQ(applied.rayleigh.alpha, 5.0);  // what was not identified stays
}

TEST_F(ParameterFile, ZeroRayleighOverrides) {
  const IdentifiedParameters p = read_parameters(write("body = \"wire\"\n[rayleigh]\nalpha = 0\nbeta = 0\n"));
  fem::Material material;
  material.rayleigh = {5.0, 1.0};
  EXPECT_EQ(apply(p, material).rayleigh.alpha, 0.0);
}

TEST_F(ParameterFile, RefusesFaultsWithFileLineAndRule) {
  const std::string head = "body = \"wire\"\n";
  const std::string good_law = "[modulus.law]\nkind = \"constant\"\nvalue = 1e11\n";
  const std::string power_law =
      "[modulus.law]\nkind = \"power\"\nvalue = 1e11\nexponent = 0.1\nreference_frequency = 100\n";
  struct Case {
    std::string text, where, what;
  };
  const std::vector<Case> cases = {
      {"body = wire\n", ":1: ", ""},
      {good_law, ": ", "has no body"},
      {head, ": ", "has no parameters"},
      {head + "colour = 1\n" + good_law, ":2: ", "unknown key \"colour\""},
      {head + "[modulus.law]\nkind = \"cubic\"\nvalue = 1\n", ":3: ", "modulus.law.kind"},
      {head + "[modulus.law]\nvalue = 1\n", ":2: ", "modulus.law has no kind"},
      {head + "[modulus.law]\nkind = \"power\"\nvalue = 1e11\nexponent = 0.1\n",
       ":2: ", "no reference_frequency"},
      {head + "[modulus.law]\nkind = \"constant\"\nvalue = \"stiff\"\n", ":4: ", "must be a number"},
      {head + "[modulus.law]\nkind = \"constant\"\nvalue = -1\n", ":2: ", "value must be positive, got -1"},
      {head + "[modulus.law]\nkind = \"constant\"\nvalue = 1e11\nexponent = 0.1\n",
       ":5: ", "unknown key \"exponent\""},
      {head + "[modulus.law]\nkind = \"table\"\nfrequency = [1, 2]\nvalue = [1]\n",
       ":2: ", "equal length, got 2 and 1"},
      {head + "[modulus]\nfrequency = [1, 2]\nvalue = [1]\nsigma = [1, 2]\n" + good_law,
       ":4: ", "equal length, got 2, 1"},
      {head + "[modulus]\nfrequency = [1]\nvalue = [1]\nsigma = [1, 2]\n" + good_law, ":4: ", "equal length"},
      {head + "[modulus]\nfrequency = [1]\nvalue = [1]\nsigma = [1]\n", ":2: ", "add [modulus.law]"},
      {head + "[modulus]\nfrequency = 1\nvalue = [1]\n", ":3: ", "must be an array of numbers"},
      {head + "[rayleigh]\nalpha = 1\n", ":2: ", "rayleigh has no beta"},
      {head + "[rayleigh]\nalpha = -1\nbeta = 0\n", ":3: ", "zero or positive, got -1"},
      {head + "[rayleigh]\nalpha = 1\nbeta = 0\nbetta = 0\n", ":5: ", "unknown key \"betta\""},
      {head + "[rayleigh]\nalpha = 1\nbeta = 0\nbeta_sigma = -1\n", ":5: ", "must not be negative"},
      {head + good_law + "covariance = [1, 2]\n", ":5: ", "1 x 1 numbers, row by row, got 2"},
      {head + good_law + "covariance = [-1]\n", ":5: ", "variances of zero or more, got -1"},
      {head + power_law + "covariance = [1, 0, 0,  1, 1, 0,  0, 0, 0]\n",
       ":7: ", "above and below the diagonal"},
      {head + power_law + "covariance = [1, 2, 0,  2, 1, 0,  0, 0, 0]\n", ":7: ", "negative variance"},
      {head + "rayleigh = 1\n", ":2: ", "must be a table"}};
  for (const Case& c : cases) {
    const std::string error = error_of(c.text);
    EXPECT_THAT(error, StartsWith(file + c.where)) << c.text;
    EXPECT_THAT(error, HasSubstr(c.what)) << c.text;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  EXPECT_THROW(read_parameters(file + ".absent"), Error);
}

}  // namespace
}  // namespace struna::ident
