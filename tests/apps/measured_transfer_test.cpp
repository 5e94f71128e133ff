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

TEST(MeasuredTransfer, SettingsAreShownAsTheyWereUsed) {
  const tests::Folder folder;
  const TransferSettings settings;
  const auto shown = transfer_settings_shown(measure(record(folder, 30.0, 0.0), settings), settings);
  const std::map<std::string, std::string> by_name(shown.begin(), shown.end());
  EXPECT_EQ(by_name.at("window"), "hann");
  EXPECT_EQ(by_name.at("resolution"), "0.25 Hz");
  EXPECT_EQ(by_name.at("segments"), "20");
  EXPECT_EQ(by_name.at("sample rate"), "1000 Hz");
  EXPECT_EQ(by_name.count("exponential decay"), 0U);
}

}  // namespace
}  // namespace struna::apps
