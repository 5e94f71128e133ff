#include "apps/usage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace struna::apps {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

template <class Step>
std::string message_of(Step step) {
  try {
    step();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

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
}

TEST(Usage, BlamingPutsTheFileBeforeAnErrorThatNamesNone) {
  EXPECT_EQ(message_of([] {
              blaming({"a.csv", "b.csv"}, []() -> int { throw Error("no line left"); });
            }),
            "a.csv: no line left");
  EXPECT_EQ(message_of([] {
              blaming({"a.csv", "b.csv"}, []() -> int { throw Error("b.csv:7: text"); });
            }),
            "b.csv:7: text");
  EXPECT_EQ(blaming({"a.csv"}, [] { return 3; }), 3);
  EXPECT_THROW(blaming({"a.csv"}, []() -> int { throw UsageError("which band?"); }), UsageError);
}

}  // namespace
}  // namespace struna::apps
