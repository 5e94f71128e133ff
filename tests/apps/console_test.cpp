#include "apps/console.hpp"

#include <gtest/gtest.h>

#include "fem/error.hpp"

namespace struna::apps {
namespace {

TEST(Console, TableAlignsNumbersToTheRightAndWordsToTheLeft) {
  const Table table{{"output", "error [dB]"}, {{"force_x", "0.5"}, {"y", "-12.25"}, {"z", "nan"}}};
  EXPECT_EQ(format(table),
            "output   error [dB]\n"
            "force_x         0.5\n"
            "y            -12.25\n"
            "z               nan\n");
}

TEST(Console, TableCountsCharactersNotBytes) {
  const Table table{{"a", "b"}, {{"η ± σ", "x"}, {"12345", "y"}}};
  EXPECT_EQ(format(table), "a      b\nη ± σ  x\n12345  y\n");
}

TEST(Console, TableLeavesNoBlanksAtTheEndOfALine) {
  EXPECT_EQ(format({{"mode", "flags"}, {{"1", "close_modes"}, {"2", ""}}}),
            "mode  flags\n   1  close_modes\n   2\n");
}

TEST(Console, TableRefusesARowLongerThanTheHeader) {
  EXPECT_THROW(format({{"a"}, {{"1", "2"}}}), Error);
}

TEST(Console, MessagesStayOnOneLine) {
  EXPECT_EQ(one_line("a\nb\tc\r\n"), "a b c");
  EXPECT_EQ(one_line(""), "");
  EXPECT_EQ(one_line("µm"), "µm");
}

TEST(Console, QuietLeavesOutTablesAndLinesButNotWarnings) {
  set_quiet(true);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  print(Table{{"a"}, {{"1"}}});
  print("done");
  progress("reading");
  warn("a doubt");
  set_quiet(false);
  std::fflush(stdout);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: a doubt\n");
}

}  // namespace
}  // namespace struna::apps
