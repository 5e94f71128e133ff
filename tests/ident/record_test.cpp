#include "ident/record.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"
#include "tests/folder.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using testing::HasSubstr;

std::string message_of(const std::string& file, const std::vector<std::string>& columns = {"force"},
                       const std::map<std::string, ChannelCorrection>& corrections = {}) {
  return tests::message_of([&] { read_record(file, columns, corrections); });
}

/// `time [s]` with a printf format, `force [N]` the row's number.
std::string rows(const char* format, double step, int count, int without = -1) {
  std::string text = "time [s],force [N]\n";
  for (int i = 0; i < count; ++i) {
    if (i == without) continue;
    char time[40];
    std::snprintf(time, sizeof time, format, 10.0 + i * step);
    text += std::string(time) + "," + std::to_string(i) + "\n";
  }
  return text;
}

TEST(Record, UnitsAndCorrectionsAreApplied) {
  const tests::Folder folder;
  const std::string file =
      folder.write("r.csv", "time [ms],force [kN],acceleration [g],raw [V]\n0,1,1,2\n1,2,-1,4\n2,3,0,6\n");
  ChannelCorrection cell;
  cell.sensitivity = 50.0;
  cell.sign = -1.0;
  cell.unit = "mN";
  cell.delay = 1e-4;
  const Record record = read_record(file, {"acceleration", "force", "raw"}, {{"raw", cell}});
  EXPECT_DOUBLE_EQ(record.sample_interval, 1e-3);
  EXPECT_DOUBLE_EQ(record.samples(0, 0), 9.80665);
  EXPECT_DOUBLE_EQ(record.samples(2, 1), 3000.0);
  EXPECT_DOUBLE_EQ(record.samples(1, 2), -0.2);
  EXPECT_EQ(record.channels[2].quantity, Quantity::force);
  EXPECT_EQ(record.channels[2].delay, 1e-4);
  EXPECT_EQ(record.samples.rows(), 3);
}

TEST(Record, TimeMayBeRoundedAsFarAsItsDigitsTell) {
  const tests::Folder folder;
  for (const char* format : {"%.4f", "%.5f", "%.9f", "%.7g", "%.3e"}) {
    // 1/2560 s = 0.390625 ms: with four decimals the written steps are 0.3 or 0.4 ms.
    if (std::string(format) == "%.3e") continue;  // see the next test
    const std::string file = folder.write("rounded.csv", rows(format, 1.0 / 2560.0, 4001));
    const Record record = read_record(file, {"force"});
    EXPECT_EQ(record.samples.rows(), 4001) << format;
    // The mean over the record is that of a whole number of samples per second, within the last digit over
    // 4000 steps.
    EXPECT_DOUBLE_EQ(record.sample_interval, 1.0 / 2560.0) << format;
  }
}

TEST(Record, AGapAJumpBackAndAStandstillInTimeAreRefusedAtTheirLine) {
  const tests::Folder folder;
  // Row 700 is line 702; without it line 702 holds row 701.
  for (const char* format : {"%.9f", "%.5f", "%.4f"}) {
    const std::string message = message_of(folder.write("gap.csv", rows(format, 1.0 / 2560.0, 2000, 700)));
    EXPECT_THAT(message, HasSubstr("gap.csv:702: a time step of")) << format;
    EXPECT_THAT(message, HasSubstr("where 0.000390")) << format;
    EXPECT_THAT(message, HasSubstr("resample")) << format;
  }
  EXPECT_THAT(message_of(folder.write("back.csv", "time [s],force [N]\n0,1\n1,1\n0.5,1\n")),
              HasSubstr("back.csv:4: time goes from 1 s to 0.5 s"));
  EXPECT_THAT(message_of(folder.write("still.csv", rows("%.3e", 1.0 / 2560.0, 2000))),
              HasSubstr("it must increase"));
  EXPECT_THAT(message_of(folder.write("drift.csv", "time [s],force [N]\n0,1\n1,1\n2,1\n3.2,1\n")),
              HasSubstr("drift.csv:5: a time step of 1.2 s where 1 s is expected"));
}

TEST(Record, FaultsAreNamedWithFileAndLine) {
  const tests::Folder folder;
  struct Fault {
    const char* content;
    const char* message;
  };
  const Fault faults[] = {
      {"", "f.csv:1: no header row"},
      {"time [s],force [N]\n", "f.csv: has 0 data row(s): a record needs at least 2"},
      {"time [s],force [N]\n0,1\n", "f.csv: has 1 data row(s)"},
      {"force [N]\n1\n2\n", "f.csv:1: no column 'time'"},
      {"time,force [N]\n0,1\n1,1\n", "f.csv:1: the time column has no unit"},
      {"time [N],force [N]\n0,1\n1,1\n", "f.csv:1: the time column's unit is 'N'"},
      {"time [h],force [N]\n0,1\n1,1\n", "f.csv:1: unknown unit 'h'"},
      {"time [s],displacement [m]\n0,1\n1,1\n", "f.csv:1: no column 'force': there are time, displacement"},
      {"time [s],force\n0,1\n1,1\n", "f.csv:1: column 'force' has no unit"},
      {"time [s],force [V]\n0,1\n1,1\n", "f.csv:1: unknown unit 'V'"},
      {"time [s],force [N]\n0,1\n1,x\n", "f.csv:3: column 'force' holds 'x'"},
      {"time [s],force [N]\n0,1\n1,nan\n", "f.csv:3: column 'force' holds 'nan'"},
      {"time [s],force [N]\n0,1\n1,inf\n", "f.csv:3: column 'force' holds 'inf'"},
      {"time [s],force [N]\n0,1\nlate,1\n", "f.csv:3: column 'time' holds 'late'"},
      {"time [s],force [N]\n0,1\n1\n", "f.csv:3: 1 fields, the header has 2"},
  };
  for (const Fault& fault : faults)
    EXPECT_THAT(message_of(folder.write("f.csv", fault.content)), HasSubstr(fault.message)) << fault.content;
  EXPECT_THAT(message_of(folder.write("f.csv", "time [s],force [N]\n0,1\n1,1\n"), {"time"}),
              HasSubstr("or is the clock"));
}

TEST(Record, CorrectionsThatMakeNoSenseAreRefused) {
  const tests::Folder folder;
  const std::string file = folder.write("f.csv", "time [s],force [N]\n0,1\n1,1\n");
  const auto with = [](auto change) {
    ChannelCorrection correction;
    change(correction);
    return std::map<std::string, ChannelCorrection>{{"force", correction}};
  };
  EXPECT_THAT(message_of(file, {"force"}, with([](auto& c) { c.sensitivity = 0; })),
              HasSubstr("sensitivity"));
  EXPECT_THAT(message_of(file, {"force"}, with([](auto& c) { c.sensitivity = NAN; })),
              HasSubstr("sensitivity"));
  EXPECT_THAT(message_of(file, {"force"}, with([](auto& c) { c.sign = 2; })), HasSubstr("sign"));
  EXPECT_THAT(message_of(file, {"force"}, with([](auto& c) { c.delay = INFINITY; })), HasSubstr("delay"));
  EXPECT_THAT(message_of(file, {"force"}, with([](auto& c) { c.unit = "V"; })),
              HasSubstr("unknown unit 'V'"));
  EXPECT_THAT(message_of(file, {"force"}, {{"foce", {}}}),
              HasSubstr("'foce': it is not among the columns used (force)"));
}

TEST(Record, WhatIsWrittenIsReadAgain) {
  const tests::Folder folder;
  Record record;
  record.start = 0.25;
  record.sample_interval = 1.0 / 25600.0;
  record.channels = {{"displacement", Quantity::displacement, 0.0}, {"force_x", Quantity::force, 0.0}};
  record.samples = Eigen::MatrixXd::Random(5000, 2);
  const std::string file = (folder / "out.csv").string();
  write_record(record, file);
  EXPECT_EQ(tests::read_text(file).substr(0, 37), "time [s],displacement [m],force_x [N]");
  const Record again = read_record(file, {"displacement", "force_x"});
  EXPECT_NEAR(again.start, 0.25, 1e-12);
  EXPECT_DOUBLE_EQ(again.sample_interval, record.sample_interval);
  // Nine digits are written.
  EXPECT_LT((again.samples - record.samples).cwiseAbs().maxCoeff(), 5e-10);
}

TEST(Record, WhatAFileCannotTellIsNotWritten) {
  const tests::Folder folder;
  Record record;
  record.sample_interval = 0.1;
  record.samples = Eigen::MatrixXd::Zero(3, 1);
  const std::string file = (folder / "out.csv").string();
  record.channels = {{"x", Quantity::unknown, 0.0}};
  EXPECT_THROW(write_record(record, file), Error);
  record.channels = {{"x", Quantity::force, 1e-3}};
  EXPECT_THROW(write_record(record, file), Error);
  record.channels = {};
  EXPECT_THROW(write_record(record, file), Error);
  record.channels = {{"x", Quantity::force, 0.0}};
  record.sample_interval = 0.0;
  EXPECT_THROW(write_record(record, file), Error);
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(Record, ATimeOfFewDigitsWithADecimalCommaIsAllowedItsRounding) {
  const tests::Folder folder;
  std::string text = rows("%.4f", 1.0 / 2048.0, 3000);
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace(text.begin(), text.end(), '.', ',');
  const Record record = read_record(folder.write("r.csv", text), {"force"});
  EXPECT_EQ(record.samples.rows(), 3000);
  // Four digits over 2999 steps.
  EXPECT_NEAR(record.sample_interval, 1.0 / 2048.0, 1e-4 / 2999.0);
  EXPECT_EQ(record.samples(2999, 0), 2999.0);
}

TEST(Record, ChannelsThatStandAtALimitAreTold) {
  const tests::Folder folder;
  std::string text = "time [s],force [N],x [mm]\n";
  for (int i = 0; i < 1000; ++i) {
    const double s = std::sin(0.05 * i);
    text +=
        std::to_string(1e-3 * i) + "," + std::to_string(std::min(s, 0.9)) + "," + std::to_string(s) + "\n";
  }
  const std::string file = folder.write("r.csv", text);
  RecordReader reader(file, {"force", "x"});
  Eigen::MatrixXd block;
  while (reader.read(block, 64) > 0) {
  }
  const auto warnings = record_warnings(file, reader.channels(), reader.watches());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr(file + ": "));
  EXPECT_THAT(warnings[0], HasSubstr("samples of 'force' stand at its largest value, 0.9 N"));
}

TEST(Record, BlocksJoinToTheWholeWhateverTheirSize) {
  const tests::Folder folder;
  const std::string file = folder.write("r.csv", rows("%.9f", 1e-3, 1003));
  for (const long size : {1L, 7L, 1003L, 5000L}) {
    RecordReader reader(file, {"force"});
    Eigen::MatrixXd block;
    double sum = 0.0;
    long count = 0;
    while (const long got = reader.read(block, size)) {
      sum += block.topRows(got).sum();
      count += got;
    }
    EXPECT_EQ(count, 1003) << size;
    EXPECT_EQ(sum, 1002.0 * 1003.0 / 2.0) << size;
    EXPECT_NEAR(reader.start(), 10.0, 1e-12);
  }
  EXPECT_EQ(count_rows(file), 1003);
  EXPECT_EQ(count_rows(folder.write("e.csv", "time [s]\n0\n1\n\n \r\n")), 2);
  EXPECT_EQ(count_rows(folder.write("e.csv", "time [s]\n0\n1")), 2);
}

}  // namespace
}  // namespace struna::ident
