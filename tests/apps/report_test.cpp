#include "apps/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>

namespace struna::apps {
namespace {

using ident::ModeFlag;
using nlohmann::json;
using std::complex_literals::operator""i;
using testing::HasSubstr;
using testing::Not;

constexpr int outputs = 3;
const std::vector<std::string> names = {"force_x", "force_y", "force_z"};

/// A wire's modes by formula: clamped-clamped frequencies, E and eta that rise slowly, constants of
/// alternating sign.
struct Wire {
  std::vector<double> frequency = {23.9,  36.6,  60.3,  118.2, 131.1, 211.2,
                                   262.7, 319.5, 391.4, 449.7, 531.9, 600.6};
  double modulus(double f) const { return 98e9 * std::pow(f / 20.0, 0.021); }
  double loss_factor(double f) const { return 0.033 * std::pow(f / 100.0, 0.03); }
  double constant(size_t mode, int output) const {
    return 0.004 * std::cos(1.7 * static_cast<double>(mode) + 2.1 * output) / (1.0 + 0.6 * output);
  }
  std::complex<double> apparent_mass(double f, int output, double scale) const {
    const double square = std::pow(2.0 * std::numbers::pi * f, 2);
    std::complex<double> sum = 0.002;
    for (size_t r = 0; r < frequency.size(); ++r) {
      const double natural = std::pow(2.0 * std::numbers::pi * frequency[r] * scale, 2);
      sum += natural * constant(r, output) / (natural * (1.0 + 1i * loss_factor(frequency[r])) - square);
    }
    return sum;
  }
};

ident::TransferFunction transfer_function(const Wire& wire, long lines, double scale, double noise) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  ident::TransferFunction tf;
  tf.frequency_hz = Eigen::VectorXd::LinSpaced(lines, 10.0, 700.0);
  for (int k = 0; k < outputs; ++k) {
    ident::TransferFunction::Output output{names[k], ident::FrfKind::dynamic_stiffness, "N/m", {}, {}, {}};
    output.value.resize(lines);
    for (long i = 0; i < lines; ++i) {
      const double f = tf.frequency_hz[i];
      output.value[i] = -std::pow(2.0 * std::numbers::pi * f, 2) * wire.apparent_mass(f, k, scale);
    }
    if (noise > 0.0) {
      output.sigma = Eigen::VectorXd::Constant(lines, noise) + 0.01 * output.value.cwiseAbs();
      output.coherence = (1.0 + (output.sigma.array() / output.value.array().abs()).square()).inverse();
      for (long i = 0; i < lines; ++i)
        output.value[i] += output.sigma[i] * std::complex<double>(normal(generator), normal(generator));
    }
    tf.outputs.push_back(output);
  }
  return tf;
}

ident::Mode mode(const Wire& wire, size_t index) {
  ident::Mode mode;
  const double f = wire.frequency[index];
  const double eta = wire.loss_factor(f);
  const double square = std::pow(2.0 * std::numbers::pi * f, 2);
  mode.natural_frequency_hz = f;
  mode.natural_frequency_sigma = 2e-4 * f;
  mode.loss_factor = eta;
  mode.loss_factor_sigma = 0.02 * eta;
  mode.damping_ratio = eta / 2.0;
  mode.lower_half_power_hz = f * std::sqrt(1.0 - eta);
  mode.upper_half_power_hz = f * std::sqrt(1.0 + eta);
  mode.window_lo_hz = f * (1.0 - eta);
  mode.window_hi_hz = f * (1.0 + eta);
  mode.circle_natural_frequency_hz = f * 1.0001;
  mode.circle_loss_factor = eta * 1.01;
  mode.modal_constant.resize(outputs);
  mode.modal_constant_sigma = Eigen::VectorXd::Constant(outputs, 0.1);
  for (int k = 0; k < outputs; ++k) {
    mode.modal_constant[k] = square * wire.constant(index, k);
    const auto share = [&](double at) {
      return mode.modal_constant[k] / (square * (1.0 + 1i * eta) - std::pow(2.0 * std::numbers::pi * at, 2));
    };
    const std::complex<double> residual = wire.apparent_mass(f, k, 1.0) - share(f);
    mode.circles.push_back({residual + share(f) / 2.0, std::abs(share(f)) / 2.0, residual + share(f),
                            residual + share(mode.lower_half_power_hz),
                            residual + share(mode.upper_half_power_hz), 0.012});
  }
  return mode;
}

ident::IdentifiedCurve curve(const std::vector<ident::Mode>& modes,
                             const std::function<double(double)>& value, double relative_sigma) {
  ident::IdentifiedCurve curve;
  std::vector<double> frequency;
  for (const auto& mode : modes)
    if (mode.flags.empty()) frequency.push_back(mode.natural_frequency_hz);
  const auto count = static_cast<long>(frequency.size());
  curve.frequency_hz = Eigen::VectorXd::Map(frequency.data(), count);
  curve.value = curve.frequency_hz.unaryExpr(value);
  curve.sigma = relative_sigma * curve.value;
  const double lo = frequency.front();
  const double hi = frequency.back();
  const double n = std::log(value(hi) / value(lo)) / std::log(hi / lo);
  curve.laws.push_back({{fem::FrequencyLaw::Kind::power, {value(100.0), n, 100.0}, {}, {}, lo, hi},
                        Eigen::Vector3d(value(100.0) * 1e-3, 2e-3, 0.0),
                        {},
                        -81.2,
                        1.08});
  curve.laws.push_back({{fem::FrequencyLaw::Kind::constant, {value(150.0)}, {}, {}, lo, hi},
                        Eigen::VectorXd::Constant(1, value(150.0) * 2e-3),
                        {},
                        -40.5,
                        6.3});
  return curve;
}

ident::Comparison comparison(double frac) {
  ident::Comparison comparison;
  comparison.lo_hz = 10.0;
  comparison.hi_hz = 700.0;
  for (const auto& name : names) {
    auto& output = comparison.outputs.emplace_back();
    output.output = name;
    output.frac = frac;
    output.log_magnitude_error_db = 0.41 / frac;
    output.mean_db = 0.05;
    output.largest_db = 2.3;
    output.peaks = {
        {23.9, 23.95, -0.1}, {36.6, 36.5, 0.2}, {60.3, std::numeric_limits<double>::quiet_NaN(), 0.0}};
  }
  return comparison;
}

ReportContent content(long lines) {
  const Wire wire;
  ReportContent content;
  content.title = "Curved wire, shaken along y";
  content.command = "struna identify study.toml -o results";
  content.settings = {{"estimator", "h1"}, {"resolution", "0.5 Hz"}, {"effective averages", "57.3"}};
  content.warnings = {"records.csv: the excitation is weak below 12 Hz"};
  content.measured = transfer_function(wire, lines, 1.0, 0.5);
  content.predicted = transfer_function(wire, lines, 1.001, 0.0);
  content.predicted_viscous = transfer_function(wire, lines, 1.01, 0.0);
  content.modes.form = ident::FrfKind::apparent_mass;
  content.modes.outputs = names;
  content.modes.units = {"kg", "kg", "kg"};
  for (size_t i = 0; i < wire.frequency.size(); ++i) content.modes.modes.push_back(mode(wire, i));
  content.modes.modes[4].flags = {ModeFlag::close_modes, ModeFlag::noisy};
  content.modes.rejected = {{50.0, "mains: no circle in any output"}};
  auto& identified = content.identified;
  identified.body = "wire";
  identified.modulus = curve(
      content.modes.modes, [&](double f) { return wire.modulus(f); }, 2e-3);
  identified.loss_factor = curve(
      content.modes.modes, [&](double f) { return wire.loss_factor(f); }, 2e-2);
  identified.kramers_kronig_loss_factor = Eigen::VectorXd::Constant(11, 0.5 * std::numbers::pi * 0.021);
  identified.rayleigh = {{4.3, 1.1e-5}, 0.4, 2e-6, 0.0, false, false, 3.2, true};
  identified.rayleigh_known = true;
  identified.rejected = {{131.1, "close_modes; noisy", ident::LeftOutOf::both}};
  for (int i = 0; i < 12; ++i)
    identified.pairing.pairs.push_back({i, i == 6 ? std::vector<int>{6, 7} : std::vector<int>{i + (i > 6)},
                                        0.99, wire.modulus(wire.frequency[static_cast<size_t>(i)]), 2e8});
  identified.pairing.missing = {13};
  identified.provenance = {
      "0.1.0", "2025-01-01T12:00:00Z", {{"records.csv", std::string(64, 'a')}}, 10.0, 700.0};
  content.comparison = comparison(0.998);
  content.comparison_viscous = comparison(0.95);
  content.input_files = {{"study.toml", "scene = \"scene.toml\"\n"}};
  return content;
}

json data_of(const std::string& page) {
  const std::string open = R"(<script type="application/json" id="report-data">)";
  const size_t start = page.find(open) + open.size();
  return json::parse(page.substr(start, page.find("</script>", start) - start));
}

TEST(Report, IsOneFileThatFetchesNothing) {
  const std::string page = render_report(content(200));
  for (const std::string reference :
       {"src=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest", "import("})
    EXPECT_THAT(page, Not(HasSubstr(reference)));
  EXPECT_THAT(page,
              HasSubstr("Released under the MIT License"));  // the chart library's licence travels with it
  EXPECT_THAT(page, Not(HasSubstr("{{")));                   // every placeholder was filled
}

TEST(Report, HoldsTheNumbersToSevenDigits) {
  const ReportContent shown = content(200);
  const json data = data_of(render_report(shown));
  const auto& output = shown.measured.outputs[1];
  for (long i = 0; i < 200; ++i) {
    // Rounding to 7 significant digits.
    EXPECT_NEAR(data["measured"]["outputs"][1]["re"][i].get<double>(), output.value[i].real(),
                5e-7 * std::abs(output.value[i].real()));
    EXPECT_NEAR(data["measured"]["outputs"][1]["im"][i].get<double>(), output.value[i].imag(),
                5e-7 * std::abs(output.value[i].imag()));
  }
  EXPECT_EQ(data["modes"]["list"].size(), 12U);
  EXPECT_EQ(data["modes"]["list"][4]["flags"], json({"close_modes", "noisy"}));
  EXPECT_FALSE(data["modes"]["list"][4]["usedForModulus"].get<bool>());
  EXPECT_TRUE(data["modes"]["list"][3]["usedForModulus"].get<bool>());
  EXPECT_FALSE(data["predicted"].contains("frequency"));  // the measured lines, not repeated
}

TEST(Report, DrawsTheFittedLawsItself) {
  const ReportContent shown = content(200);
  const json data = data_of(render_report(shown))["identified"];
  const auto& law = shown.identified.modulus.laws.front().law;
  for (size_t i = 0; i < data["curveFrequency"].size(); ++i) {
    const double f = data["curveFrequency"][i];
    // Half of the 6th significant digit; 7 digits of the frequency change it far less.
    EXPECT_NEAR(data["modulus"]["laws"][0]["curve"][i].get<double>(), law.at(f), 5.1e-6 * law.at(f));
    EXPECT_NEAR(data["rayleigh"]["curve"][i].get<double>(),
                fem::rayleigh_damping_ratio(shown.identified.rayleigh.rayleigh, f), 2e-6);
  }
}

TEST(Report, ShowsTheLinesOfAModeInCircleForm) {
  ReportContent shown = content(4000);
  shown.measured = transfer_function(Wire{}, 4000, 1.0, 0.0);
  const auto& mode = shown.modes.modes[3];
  const json lines = data_of(render_report(shown))["modes"]["list"][3]["lines"];
  const double spacing = 690.0 / 3999.0;
  EXPECT_NEAR(static_cast<double>(lines["frequency"].size()),
              (mode.window_hi_hz - mode.window_lo_hz) / spacing, 1.0);
  for (size_t k = 0; k < outputs; ++k)
    for (size_t i = 0; i < lines["frequency"].size(); ++i) {
      const std::complex<double> exact =
          Wire{}.apparent_mass(lines["frequency"][i], static_cast<int>(k), 1.0);
      // 7 digits of the frequency, times the steepness of a resonance, 2/eta = 60.
      EXPECT_NEAR(lines["outputs"][k]["re"][i].get<double>(), exact.real(), 1e-4 * std::abs(exact));
      EXPECT_NEAR(lines["outputs"][k]["im"][i].get<double>(), exact.imag(), 1e-4 * std::abs(exact));
    }
}

TEST(Report, WritesWhatIsNotANumberAsNull) {
  ReportContent shown = content(50);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  shown.measured.outputs[0].value[3] = {nan, 1.0};
  shown.modes.modes[2].circle_natural_frequency_hz = nan;
  shown.modes.modes[2].natural_frequency_sigma = std::numeric_limits<double>::infinity();
  const json data = data_of(render_report(shown));
  EXPECT_TRUE(data["measured"]["outputs"][0]["re"][3].is_null());
  EXPECT_TRUE(data["modes"]["list"][2]["circleFrequency"].is_null());
  EXPECT_TRUE(data["modes"]["list"][2]["frequencySigma"].is_null());
}

TEST(Report, TextCannotLeaveItsPlace) {
  ReportContent shown = content(50);
  const std::string hostile = "</script><script>alert(1)</script><!-- {{js}} & \"";
  shown.title = hostile;
  shown.warnings = {hostile, "not UTF-8: \xff"};
  shown.input_files = {{hostile, hostile}};
  const std::string page = render_report(shown);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert(1)")));
  EXPECT_THAT(page, HasSubstr("<title>&lt;/script&gt;"));
  EXPECT_EQ(data_of(page)["warnings"][0], hostile);
  EXPECT_EQ(data_of(page)["title"], hostile);
}

TEST(Report, StaysSmall) {
  const size_t size = render_report(content(4000)).size();
  RecordProperty("kilobytes", static_cast<int>(size / 1000));
  EXPECT_LT(size, 3'000'000U);
}

/// What a browser makes of the page: its document after the scripts ran.
class InBrowser : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "chromium is not installed";
    folder_ = std::filesystem::temp_directory_path() / ("struna_report_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string document_of(const ReportContent& shown) const {
    const auto page = folder_ / "report.html";
    std::ofstream(page) << render_report(shown);
    const std::string run =
        "chromium --headless --no-sandbox --disable-gpu --window-size=1400,9000 --user-data-dir=" +
        (folder_ / "profile").string() + " --virtual-time-budget=20000 --dump-dom file://" + page.string() +
        " > " + (folder_ / "dom.html").string() + " 2> /dev/null";
    EXPECT_EQ(std::system(run.c_str()), 0);
    std::stringstream document;
    document << std::ifstream(folder_ / "dom.html").rdbuf();
    return document.str();
  }

  std::filesystem::path folder_;
};

void expect_sound(const std::string& document) {
  EXPECT_THAT(document, HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(document, HasSubstr("id=\"script-errors\" role=\"alert\" hidden"));
}

size_t count(const std::string& text, const std::string& word) {
  size_t found = 0;
  for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

TEST_F(InBrowser, DrawsEveryPlotWithoutScriptErrors) {
  const std::string document = document_of(content(500));
  expect_sound(document);
  EXPECT_EQ(count(document, "<canvas"),
            9U + 3U + 12U);  // Bode of 3 outputs; E, eta, zeta; a circle plot per mode
  EXPECT_THAT(
      document,
      HasSubstr("12 modes found between 23.9 and 600.6 Hz, 11 trusted for the modulus, 11 for the damping."));
}

TEST_F(InBrowser, DoubtsComeFirstAndBarConclusions) {
  ReportContent doubted = content(500);
  ident::Doubt offset;
  offset.kind = ident::DoubtKind::level_offset;
  offset.count = 12;
  offset.value = 1000.0;
  doubted.doubts = {offset};
  ident::withdraw_trust(doubted.identified);
  const std::string document = document_of(doubted);
  expect_sound(document);
  // As the browser has put it together; the script's own texts are in the page too.
  ASSERT_THAT(document, HasSubstr("<li>the measured function is 1000 times larger"));
  EXPECT_LT(document.find("<li>the measured function is"), document.find("12 modes found"));
  EXPECT_THAT(document, HasSubstr("0 trusted for the modulus, 0 for the damping. Which damping model is the "
                                  "closer one cannot be told"));
  EXPECT_EQ(document.find("The structural damping model is"), std::string::npos);
}

TEST_F(InBrowser, OutputsThatAreNotDefinedTakeNoPartInTheVerdict) {
  ReportContent one = content(500);
  ASSERT_GE(one.comparison.outputs.size(), 2U);
  for (ident::Comparison* comparison : {&one.comparison, &one.comparison_viscous}) {
    for (std::size_t k = 0; k < comparison->outputs.size(); ++k) {
      auto& output = comparison->outputs[k];
      output.log_magnitude_error_db = k == 0 ? (comparison == &one.comparison ? 1.25 : 2.5) : std::nan("");
      if (k > 0) output.frac = std::nan("");
    }
  }
  EXPECT_THAT(document_of(one), HasSubstr("(1.25 against 2.5 dB rms, mean over 1 output)"));
}

TEST_F(InBrowser, ShowsWhatThereIsWhenNothingWasIdentified) {
  ReportContent bare;
  bare.title = "bare";
  bare.measured = transfer_function(Wire{}, 100, 1.0, 0.0);
  for (auto& output : bare.measured.outputs) {
    output.kind = ident::FrfKind::unknown;
    output.unit = "V/Pa";
  }
  const std::string document = document_of(bare);
  expect_sound(document);
  EXPECT_EQ(count(document, "<canvas"), 6U);  // magnitude and phase only
  EXPECT_THAT(document, HasSubstr("0 modes found"));
}

}  // namespace
}  // namespace struna::apps
