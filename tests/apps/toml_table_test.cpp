#include "apps/toml_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/folder.hpp"
#include "tests/message_of.hpp"

namespace struna::apps {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using tests::message_of;

/// A table from text, as if it had stood in a file named f.toml.
struct Parsed {
  explicit Parsed(const std::string& text) : content(toml::parse(text)), table(content, "dir/f.toml") {}
  toml::table content;
  TomlTable table;
};

TEST(TomlTable, ReadsEveryKindOfValue) {
  Parsed p(R"(
number = 1.5
integer = 3
text = "word"
flag = true
numbers = [1, 2.5]
texts = ["a", "b"]
vector = [1, 2, 3]
vectors = [[0, 0, 0], [1, 2, 3]]
file = "../x.csv"
files = ["a.csv", "/b.csv"]
band = [10, 20]
band_text = "1:2"
[table]
inner = 1
[[entry]]
[[entry]]
)");
  TomlTable& t = p.table;
  EXPECT_EQ(t.number("number"), 1.5);
  EXPECT_EQ(t.number("integer"), 3.0);
  EXPECT_EQ(t.number("absent", 7.0), 7.0);
  EXPECT_EQ(t.positive("number"), 1.5);
  EXPECT_EQ(t.not_negative("absent", 0.5), 0.5);
  EXPECT_EQ(t.integer("integer", 0), 3);
  EXPECT_EQ(t.integer("absent", 4), 4);
  EXPECT_EQ(t.text("text"), "word");
  EXPECT_EQ(t.text("absent", "other"), "other");
  EXPECT_TRUE(t.flag("flag", false));
  EXPECT_TRUE(t.flag("absent", true));
  EXPECT_THAT(t.numbers("numbers"), ElementsAre(1.0, 2.5));
  EXPECT_THAT(t.texts("texts"), ElementsAre("a", "b"));
  EXPECT_EQ(t.vector3("vector"), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(t.vectors3("vectors").at(1), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(t.path("file"), "x.csv");
  EXPECT_THAT(t.paths("files"), ElementsAre("dir/a.csv", "/b.csv"));
  EXPECT_EQ(t.band("band").hi_hz, 20.0);
  EXPECT_EQ(t.band("band_text").lo_hz, 1.0);
  EXPECT_EQ(t.table("table").number("inner"), 1.0);
  EXPECT_EQ(t.tables("entry").size(), 2U);
  EXPECT_EQ(t.tables("absent").size(), 0U);
  EXPECT_EQ(t.choice<int>("text", {{"word", 5}, {"other", 6}}), 5);
  EXPECT_EQ(t.choice<int>("absent", {{"word", 5}}, 9), 9);
  EXPECT_NO_THROW(t.finish());
}

TEST(TomlTable, WrongTypesAndValuesAreErrorsWithTheirLine) {
  Parsed p(R"(number = "1"
nan = nan
text = 1
empty = ""
flag = 1
integer = 1.5
big = 99999999999
numbers = [1,
  "2"]
texts = ["a", 2]
short = [1, 2]
vectors = [[0, 0, 0],
           [1, 2]]
band = [20, 10]
band_text = "20"
word = "wrod"
table = 1
[entry]
negative = -1
)");
  TomlTable& t = p.table;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {message_of([&] { t.number("number"); }), "dir/f.toml:1: number must be a number, got text"},
      {message_of([&] { t.number("nan"); }), "dir/f.toml:2: nan must be a finite number, got nan"},
      {message_of([&] { t.text("text"); }), "dir/f.toml:3: text must be text in quotes, got an integer"},
      {message_of([&] { t.text("empty"); }), "dir/f.toml:4: empty must not be empty"},
      {message_of([&] { t.flag("flag", true); }), "dir/f.toml:5: flag must be true or false, got an integer"},
      {message_of([&] { t.integer("integer", 0); }),
       "dir/f.toml:6: integer must be an integer, got a number"},
      {message_of([&] { t.integer("big", 0); }), "dir/f.toml:7: big is out of range, got 99999999999"},
      {message_of([&] { t.numbers("numbers"); }), "dir/f.toml:9: numbers must hold numbers only, got text"},
      {message_of([&] { t.texts("texts"); }),
       "dir/f.toml:10: texts must hold texts in quotes only, got an integer"},
      {message_of([&] { t.vector3("short"); }),
       "dir/f.toml:11: short needs three numbers [x, y, z], got 2 entries"},
      {message_of([&] { t.vectors3("vectors"); }),
       "dir/f.toml:13: vectors needs three numbers [x, y, z], got 2 entries"},
      {message_of([&] { t.band("band"); }),
       "dir/f.toml:14: band needs [lo, hi] in Hz with 0 <= lo < hi, got [20, 10]"},
      {message_of([&] { t.band("band_text"); }),
       "dir/f.toml:15: band_text is no band: a band is LO:HI in Hz, such as 10:1000, got '20'"},
      {message_of([&] {
         t.choice<int>("word", {{"word", 1}, {"other", 2}});
       }),
       "dir/f.toml:16: word must be one of word, other, got 'wrod'"},
      {message_of([&] { t.table("table"); }), "dir/f.toml:17: table must be a table, got an integer"},
      {message_of([&] { t.tables("entry"); }),
       "dir/f.toml:18: entry must be written [[entry]], as there may be several, got a table"},
      {message_of([&] { t.table("entry").positive("negative"); }),
       "dir/f.toml:19: entry.negative must be > 0, got -1"},
      {message_of([&] { t.table("entry").not_negative("negative"); }),
       "dir/f.toml:19: entry.negative must be >= 0, got -1"},
      {message_of([&] { t.number("absent"); }), "dir/f.toml: absent is missing and must be given"},
      {message_of([&] { t.table("entry").number("absent"); }),
       "dir/f.toml:18: entry.absent is missing and must be given"},
  };
  for (const auto& [got, expected] : cases) EXPECT_EQ(got, expected);
}

TEST(TomlTable, FinishRefusesTheFirstKeyThatNobodyAskedFor) {
  Parsed p("density = 1\nzeta = 2\npoison = 0.3\n");
  p.table.number("density");
  p.table.number("poisson", 0.3);
  EXPECT_EQ(message_of([&] { p.table.finish(); }),
            "dir/f.toml:2: zeta is not a known key; known here: density, poisson");
  p.table.number("zeta");
  EXPECT_EQ(message_of([&] { p.table.finish(); }),
            "dir/f.toml:3: poison is not a known key; did you mean 'poisson'?");
}

TEST(TomlTable, AMissingKeyPointsAtItsMisspelling) {
  Parsed p("densty = 1\n");
  EXPECT_THAT(message_of([&] { p.table.number("density"); }),
              EndsWith("(is that what 'densty' stands for?)"));
}

TEST(TomlTable, NearestWordIsNearOrNone) {
  EXPECT_EQ(nearest_word("diametre", {"density", "diameter"}), "diameter");
  EXPECT_EQ(nearest_word("modulus", {"gap", "law"}), "");
  EXPECT_EQ(nearest_word("x", {"y"}), "");
}

TEST(TomlTable, SyntaxErrorsAndUnreadableFilesNameTheFileAndLine) {
  const tests::Folder folder;
  const std::string broken = folder.write("broken.toml", "a = 1\nb = = 2\n");
  EXPECT_THAT(message_of([&] { parse_toml(broken); }), HasSubstr(broken + ":2: is not valid TOML"));
  const std::string twice = folder.write("twice.toml", "a = 1\na = 2\n");
  EXPECT_THAT(message_of([&] { parse_toml(twice); }), HasSubstr(twice + ":2: "));
  EXPECT_THAT(message_of([&] { parse_toml((folder / "absent.toml").string()); }),
              HasSubstr("cannot be read"));
  EXPECT_THAT(message_of([&] { parse_toml(folder.path().string()); }), HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace struna::apps
