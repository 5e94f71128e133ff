#include "apps/usage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/folder.hpp"
#include "tests/message_of.hpp"

namespace struna::apps {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using tests::message_of;

TEST(Usage, BandIsReadAsTwoNumbersInHertz) {
  const Band band = parse_band("10:1e3");
  EXPECT_EQ(band.lo_hz, 10.0);
  EXPECT_EQ(band.hi_hz, 1000.0);
  EXPECT_EQ(parse_band("0:0.5").lo_hz, 0.0);
}

TEST(Usage, BandRefusesWhatIsNotTwoRisingNumbers) {
  for (const char* text : {"", ":", "10", "10:", ":10", "10:x", "a:10", "10-20", "10:20:30", "10: 20",
                           "nan:10", "1:inf", "20:10", "10:10", "-1:10"}) {
    EXPECT_THROW(parse_band(text), UsageError) << text;
    EXPECT_THAT(message_of([&] { parse_band(text); }), HasSubstr(std::string("'") + text + "'"));
  }
}

TEST(Usage, ModulusRangeIsTwoRisingPositiveNumbers) {
  EXPECT_EQ(parse_modulus_range("1e10:3e11"), std::make_pair(1e10, 3e11));
  for (const char* text : {"", "1e10", "0:1e11", "-1:1", "3e11:1e10", "1e10:1e10", "a:b"}) {
    EXPECT_THROW(parse_modulus_range(text), UsageError) << text;
    EXPECT_THAT(message_of([&] { parse_modulus_range(text); }), HasSubstr("--modulus-range")) << text;
  }
}

TEST(Usage, OptionValueTurnsAReadersErrorIntoWrongUsage) {
  const auto reader = [](const std::string& word) -> int {
    if (word == "one") return 1;
    throw Error("not a number: " + word);
  };
  EXPECT_EQ(option_value("--count", "one", reader), 1);
  EXPECT_THROW(option_value("--count", "two", reader), UsageError);
  EXPECT_EQ(message_of([&] { option_value("--count", "two", reader); }), "--count: not a number: two");
  EXPECT_EQ(option_value("--count", "ONE", reader), 1);
  const auto named = [](const std::string& word) -> int { throw Error("damping: not so, got " + word); };
  EXPECT_EQ(message_of([&] { option_value("--damping", "dry", named); }), "--damping: not so, got dry");
}

TEST(Usage, AnErrorsReasonLeavesOutTheFunctionButNoFileAndNoSentence) {
  for (const char* function :
       {"find_hit", "MotionHistory::at", "to_string(ModeFlag)", "ModalStepper", "fit"}) {
    EXPECT_EQ(Error(std::string(function) + ": at least one, got none").reason(), "at least one, got none");
  }
  EXPECT_EQ(Error("records", 0, "cannot be opened").reason(), "records: cannot be opened");
  EXPECT_EQ(Error("a.csv", 3, "text").reason(), "a.csv:3: text");
  for (const char* plain : {"closed form: no", "body 'wire': no", "--band: no", ": no", "no colon", ""}) {
    EXPECT_EQ(Error(plain).reason(), plain);
  }
  EXPECT_TRUE(Error("a.csv", 0, "text").names_file());
  EXPECT_FALSE(Error("a.csv: text").names_file());
}

TEST(Usage, AFileToWriteThatIsReadIsRefusedThroughEveryLink) {
  namespace fs = std::filesystem;
  const tests::Folder folder;
  const std::string file = folder.write("a.csv", "a");
  const auto name = [&](const char* other) { return (folder / other).string(); };
  fs::create_symlink("a.csv", name("soft.csv"));
  fs::create_hard_link(file, name("hard.csv"));
  fs::create_directory_symlink(folder.path(), name("here"));
  for (const char* same : {"a.csv", "soft.csv", "hard.csv", "here/a.csv", "here/./a.csv"}) {
    const std::string got = message_of([&] {
      refuse_overwriting({{"-o", name(same)}}, {name("b.csv"), file});
    });
    EXPECT_THAT(got, StartsWith("-o " + name(same) + ": would overwrite its own input")) << same;
  }
  EXPECT_THAT(message_of([&] {
                refuse_overwriting({{"-o", name("new.csv")}, {"--contacts", name("here/new.csv")}}, {});
              }),
              HasSubstr("-o writes to the same file"));
  EXPECT_NO_THROW(refuse_overwriting({{"-o", name("b.csv")}, {"--contacts", name("c.csv")}}, {file}));
  EXPECT_NO_THROW(refuse_overwriting({{"-o", "/dev/null"}, {"--contacts", "/dev/null"}}, {"/dev/null"}));
}

TEST(Usage, BlamingPutsTheFileBeforeAnErrorThatNamesNone) {
  EXPECT_EQ(message_of([] {
              blaming({"a.csv", "b.csv"}, []() -> int { throw Error("no line left"); });
            }),
            "a.csv: no line left");
  EXPECT_EQ(message_of([] {
              blaming({"a.csv", "b.csv"}, []() -> int { throw Error("c.csv", 7, "text"); });
            }),
            "c.csv:7: text");
  EXPECT_EQ(
      message_of([] { blaming({"a.csv"}, []() -> int { throw Error("find_hit: the force is constant"); }); }),
      "a.csv: the force is constant");
  EXPECT_EQ(blaming({"a.csv"}, [] { return 3; }), 3);
  EXPECT_THROW(blaming({"a.csv"}, []() -> int { throw UsageError("which band?"); }), UsageError);
}

}  // namespace
}  // namespace struna::apps
