#include "apps/measured_transfer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::apps {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// White displacement and twice its second difference as a force, with sensor noise on the displacement.
std::string record(const tests::Folder& folder, double duration, double displacement_noise,
                   bool coherent = true) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  ident::Record record;
  record.sample_interval = 1e-3;
  record.channels = {{"displacement", ident::Quantity::displacement, 0.0},
                     {"force", ident::Quantity::force, 0.0}};
  record.samples.resize(static_cast<long>(duration / record.sample_interval), 2);
  double x = 0.0, before = 0.0;
  for (long i = 0; i < record.samples.rows(); ++i) {
    const double next = 0.95 * x + normal(random);
    record.samples(i, 0) = x + displacement_noise * normal(random);
    record.samples(i, 1) = coherent ? 2.0 * (next - 2.0 * x + before) : normal(random);
    before = x;
    x = next;
  }
  const std::string file = (folder / "record.csv").string();
  ident::write_record(record, file);
  return file;
}

MeasuredTransfer measure(const std::string& file, const TransferSettings& settings) {
  return measure_transfer({file}, "displacement", {"force"}, {}, settings);
}

TEST(MeasuredTransfer, AppliesBandAndForm) {
  const tests::Folder folder;
  const std::string file = record(folder, 20.0, 0.0);
  TransferSettings settings;
  settings.welch.resolution_hz = 1.0;
  settings.band = Band{10.0, 200.0};
  const auto as_measured = measure(file, settings).function;
  EXPECT_EQ(as_measured.lines(), 191);
  EXPECT_EQ(as_measured.outputs[0].unit, "N/m");
  settings.form = ident::FrfKind::apparent_mass;
  EXPECT_EQ(measure(file, settings).function.outputs[0].unit, "kg");
}

TEST(MeasuredTransfer, SoundDataRaiseNoWarning) {
  const tests::Folder folder;
  EXPECT_THAT(measure(record(folder, 30.0, 0.0), {}).warnings, IsEmpty());
}

TEST(MeasuredTransfer, ANoiseFloorAtTheTopOfTheBandIsPointedOut) {
  // x falls as 1/f, its noise does not: they are equal at 160 Hz.
  const tests::Folder folder;
  EXPECT_THAT(measure(record(folder, 30.0, 1.0), {}).warnings,
              ElementsAre(AllOf(HasSubstr("force: coherence is below 0.8"), HasSubstr("narrow the band"),
                                HasSubstr("noise floor"))));
}

TEST(MeasuredTransfer, ARecordWithoutAnyCoherenceSaysSoWithoutABand) {
  const tests::Folder folder;
  EXPECT_THAT(measure(record(folder, 30.0, 0.0, false), {}).warnings,
              ElementsAre(AllOf(HasSubstr("100 % of the lines"), testing::Not(HasSubstr("narrow")))));
}

TEST(MeasuredTransfer, FewAveragesAreWarnedOf) {
  const tests::Folder folder;
  TransferSettings settings;
  settings.welch.resolution_hz = 0.4;
  EXPECT_THAT(measure(record(folder, 5.0, 0.0), settings).warnings,
              ElementsAre(HasSubstr("effective averages")));
}

std::map<std::string, std::string> shown(const std::string& file, const TransferSettings& settings) {
  const auto pairs = transfer_settings_shown(measure(file, settings));
  return {pairs.begin(), pairs.end()};
}

TEST(MeasuredTransfer, SettingsAreShownAsTheyWereUsed) {
  const tests::Folder folder;
  const std::string file = record(folder, 30.0, 0.0);
  const auto automatic = shown(file, {});
  EXPECT_EQ(automatic.at("estimator"), "local rational model");
  EXPECT_EQ(automatic.at("chosen because"), "steady excitation that does not repeat itself");
  EXPECT_EQ(automatic.at("resolution"), "0.25 Hz");
  EXPECT_EQ(automatic.at("records"), "1");
  EXPECT_EQ(automatic.at("sample rate"), "1000 Hz");
  EXPECT_EQ(automatic.count("window"), 0U);
  EXPECT_EQ(automatic.count("exponential decay"), 0U);
  TransferSettings settings;
  settings.method = ident::EstimateMethod::welch;
  const auto welch = shown(file, settings);
  EXPECT_EQ(welch.at("estimator"), "h1, Welch");
  EXPECT_EQ(welch.at("chosen because"), "asked for");
  EXPECT_EQ(welch.at("window"), "hann");
  EXPECT_EQ(welch.at("segments"), "20");
}

// A resonance at 100 Hz of zeta 0.1 %: six lines of 30 s in its half-power band, less than one of a segment.
TEST(MeasuredTransfer, ResonancesTooNarrowForTheEstimatorAreWarnedOf) {
  const tests::Folder folder;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  ident::Record made;
  made.sample_interval = 1e-3;
  made.channels = {{"force", ident::Quantity::force, 0.0},
                   {"displacement", ident::Quantity::displacement, 0.0}};
  made.samples.resize(30000, 2);
  const double decay = 2e-3 * M_PI * 100.0 * made.sample_interval;
  const double turn = 2.0 * M_PI * 100.0 * made.sample_interval;
  double y1 = 0.0, y2 = 0.0;
  for (long i = 0; i < made.samples.rows(); ++i) {
    const double x = normal(random),
                 y = x + 2.0 * std::exp(-0.5 * decay) * std::cos(turn) * y1 - std::exp(-decay) * y2;
    made.samples.row(i) << x, y;
    y2 = y1;
    y1 = y;
  }
  const std::string file = (folder / "narrow.csv").string();
  ident::write_record(made, file);
  const auto warnings = [&](ident::EstimateMethod method) {
    TransferSettings settings;
    settings.method = method;
    return measure_transfer({file}, "force", {"displacement"}, {}, settings).warnings;
  };
  EXPECT_THAT(
      warnings(ident::EstimateMethod::welch),
      testing::Contains(AllOf(HasSubstr("few lines of"), HasSubstr("at 100 Hz"), HasSubstr("leakage lowers"),
                              HasSubstr("damping may keep the half"), HasSubstr("--estimator local"))));
  EXPECT_THAT(warnings(ident::EstimateMethod::automatic),
              testing::Not(testing::Contains(HasSubstr("half-power band"))));
}

}  // namespace
}  // namespace struna::apps
