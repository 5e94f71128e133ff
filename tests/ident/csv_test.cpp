#include "ident/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <random>

#include "fem/error.hpp"
#include "tests/folder.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using testing::HasSubstr;

/// Both ways of reading a file of one column: through fields and through numbers.
std::vector<double> read_fields(const std::string& file) {
  CsvReader csv(file);
  std::vector<std::string_view> fields;
  std::vector<double> values;
  while (csv.next(fields)) values.push_back(csv.number(fields, 0));
  return values;
}
std::vector<double> read_numbers(const std::string& file) {
  CsvReader csv(file);
  std::vector<double> number(1);
  int last_digit = 0;
  std::vector<double> values;
  while (csv.next_numbers({0}, number, last_digit)) values.push_back(number[0]);
  return values;
}

std::string message_of(const std::string& file, std::vector<double> (*read)(const std::string&)) {
  return tests::message_of([&] { read(file); });
}

TEST(Csv, NumbersAreTheNearestDoubles) {
  // strtod rounds correctly: no tolerance.
  const tests::Folder folder;
  std::mt19937_64 random(7);
  std::vector<std::string> texts{"0",
                                 "-0",
                                 "1",
                                 "+2.5",
                                 " 3 ",
                                 "\t4",
                                 "1e5",
                                 "1E-5",
                                 ".5",
                                 "5.",
                                 "1e+22",
                                 "1e23",
                                 "9007199254740993",
                                 "123456789012345678901234567890",
                                 "1e-320",
                                 "4.9e-324",
                                 "1.7976931348623157e308",
                                 "0.000001",
                                 "123456789012345",
                                 "-0.1234567890123456789",
                                 "1e-400",
                                 "00012.5"};
  for (int i = 0; i < 20000; ++i) {
    char text[64];
    const double value = std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 140) - 120);
    std::snprintf(text, sizeof text,
                  i % 3 == 0   ? "%.*g"
                  : i % 3 == 1 ? "%.*e"
                               : "%.*f",
                  static_cast<int>(random() % 18), i % 3 == 2 ? std::fmod(value, 1e6) : value);
    texts.emplace_back(i % 2 == 0 ? text : std::string("-") + text);
  }
  std::string content = "x\n";
  for (const auto& text : texts) content += text + "\n";
  const std::string file = folder.write("numbers.csv", content);
  for (const auto& values : {read_fields(file), read_numbers(file)}) {
    ASSERT_EQ(values.size(), texts.size());
    for (std::size_t i = 0; i < texts.size(); ++i)
      EXPECT_EQ(values[i], std::strtod(texts[i].c_str(), nullptr)) << texts[i];
  }
}

TEST(Csv, WhatIsNoFiniteNumberIsRefusedWithFileLineAndColumn) {
  const tests::Folder folder;
  for (const char* text : {"abc",  "1.2.3", "1e",   "e5",  "-",   "+",   "1 2", "nan", "inf", "-inf",
                           "0x10", "1e400", "1,5x", "--1", "+-1", "1e-", "1e+", "٣",   ".",   "-."}) {
    const std::string file = folder.write("bad.csv", std::string("force [N]\n1\n") + text + "\n2\n");
    if (std::string_view(text).find(',') != std::string_view::npos) continue;
    for (const auto& message : {message_of(file, read_fields), message_of(file, read_numbers)}) {
      EXPECT_THAT(message, HasSubstr("bad.csv:3: ")) << text;
      EXPECT_THAT(message, HasSubstr("force")) << text;
    }
  }
}

TEST(Csv, WindowsLinesByteOrderMarksQuotesAndMissingLastLineEndAreRead) {
  const tests::Folder folder;
  const std::string file = folder.write("dos.csv", "\xEF\xBB\xBF\"x [m]\",y [N]\r\n1, 2\r\n 3 ,4\r\n5,6");
  CsvReader csv(file);
  EXPECT_EQ(csv.header()[0].name, "x");
  EXPECT_EQ(csv.header()[1].unit, "N");
  std::vector<double> row(2);
  int last_digit = 0;
  double sum = 0;
  while (csv.next_numbers({1, 0}, row, last_digit)) sum += row[0] * 10 + row[1];
  EXPECT_EQ(sum, (2 + 4 + 6) * 10 + 1 + 3 + 5);
}

TEST(Csv, ColumnsThatAreNotWantedAreNotRead) {
  const tests::Folder folder;
  CsvReader csv(folder.write("notes.csv", "x,note,y\n1,hello,2\n3,,4\n"));
  std::vector<double> row(2);
  int last_digit = 0;
  ASSERT_TRUE(csv.next_numbers({0, -1, 1}, row, last_digit));
  EXPECT_EQ(row[1], 2.0);
  EXPECT_EQ(last_digit, 0);
  ASSERT_TRUE(csv.next_numbers({0, -1, 1}, row, last_digit));
  EXPECT_EQ(row[1], 4.0);
  EXPECT_FALSE(csv.next_numbers({0, -1, 1}, row, last_digit));
}

TEST(CsvReader, TellsThePlaceOfTheLastDigitHoweverANumberIsWritten) {
  const tests::Folder folder;
  const std::pair<const char*, int> cases[] = {
      {"0", 0},           {"120", 0},     {"0.125", -3}, {"1.2e2", 1}, {"1.25e-05", -7},
      {"-3.", 0},         {" 0.5 ", -1},  {"+0.25", -2}, {"1E3", 3},   {"0.12345678901234567", -17},
      {"0.00001234", -8}, {"1.50000", -5}};
  std::string content = "time [s]\n";
  for (const auto& [text, place] : cases) content += std::string(text) + "\n";
  CsvReader csv(folder.write("places.csv", content));
  std::vector<double> number(1);
  for (const auto& [text, place] : cases) {
    int last_digit = 99;
    ASSERT_TRUE(csv.next_numbers({0}, number, last_digit)) << text;
    EXPECT_EQ(last_digit, place) << text;
  }
}

TEST(Csv, SemicolonsTabsAndDecimalCommasReadAsTheSameNumbers) {
  // The same doubles: no tolerance.
  const tests::Folder folder;
  const std::vector<std::vector<std::string>> rows = {
      {"0", "-3", "1e2"}, {"0.001", "2.5", "-1.25E-3"}, {"0.002", "0.12345678901234567890", " +4.5 "}};
  for (const char separator : {',', ';', '\t'}) {
    for (const char decimal : {'.', ','}) {
      if (separator == ',' && decimal == ',') continue;
      std::string content =
          std::string("time [s]") + separator + "note" + separator + "x [m]" + separator + "y\n";
      for (const auto& row : rows) {
        std::string line = row[0] + separator + "n" + separator + row[1] + separator + row[2] + "\n";
        std::replace(line.begin(), line.end(), '.', decimal);
        content += line;
      }
      const std::string file = folder.write("f.csv", content);
      CsvReader by_number(file);
      CsvReader by_field(file);
      EXPECT_EQ(by_number.header()[2].unit, "m");
      std::vector<double> numbers(3);
      std::vector<std::string_view> fields;
      int last_digit = 0;
      for (const auto& row : rows) {
        ASSERT_TRUE(by_number.next_numbers({0, -1, 1, 2}, numbers, last_digit)) << content;
        ASSERT_TRUE(by_field.next(fields)) << content;
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_EQ(numbers[k], std::strtod(row[k].c_str(), nullptr)) << content;
          EXPECT_EQ(by_field.number(fields, k == 0 ? 0 : static_cast<int>(k) + 1), numbers[k]) << content;
        }
      }
      EXPECT_FALSE(by_number.next_numbers({0, -1, 1, 2}, numbers, last_digit));
    }
  }
}

TEST(Csv, TabsBesideCommasAreBlanks) {
  const tests::Folder folder;
  CsvReader csv(folder.write("blanks.csv", "x [m],\ty [N]\n1,\t2.5\n"));
  std::vector<double> row(2);
  int last_digit = 0;
  ASSERT_TRUE(csv.next_numbers({0, 1}, row, last_digit));
  EXPECT_EQ(row[1], 2.5);
}

TEST(Csv, BlankLinesAtTheEndArePassedOver) {
  const tests::Folder folder;
  EXPECT_EQ(read_fields(folder.write("a.csv", "x\n1\n\n  \n\r\n")).size(), 1U);
  EXPECT_EQ(read_numbers(folder.write("b.csv", "x\n1\n\n  \n\r\n")).size(), 1U);
}

TEST(Csv, LongFilesCrossTheReadersBlocksUnharmed) {
  // The reader underneath moves blocks of 16 MiB.
  const tests::Folder folder;
  std::string content = "x,y\n";
  const long rows = 2500000;
  for (long i = 0; i < rows; ++i) content += std::to_string(i) + ",0.123456789\n";
  CsvReader csv(folder.write("long.csv", content));
  std::vector<double> row(2);
  int last_digit = 0;
  long i = 0;
  for (; csv.next_numbers({0, 1}, row, last_digit); ++i) ASSERT_EQ(row[0], static_cast<double>(i));
  EXPECT_EQ(i, rows);
  EXPECT_EQ(csv.line(), rows + 1);
}

TEST(Csv, FaultsOfTheFileNameFileLineAndCure) {
  const tests::Folder folder;
  struct Fault {
    const char* content;
    const char* where;
    const char* what;
  };
  const Fault faults[] = {
      {"", "f.csv:1: ", "no header row"},
      {"\n1\n", "f.csv:1: ", "no header row"},
      {"x;y,z\n1;2\n", "f.csv:1: ", "more than one of comma, semicolon and tab"},
      {"x\ty;z\n1\t2\n", "f.csv:1: ", "more than one of comma, semicolon and tab"},
      {"x,y\n1,0,2,0\n", "f.csv:2: ", "with decimal commas, columns must be separated by"},
      {"x;y\n1;2,5\n1;2.5\n", "f.csv:3: ", "numbers before it have a decimal comma"},
      {"x\ty\n1\t2.5\n1\t2,5\n", "f.csv:3: ", "numbers before it have a decimal point"},
      {"x;y\n1;1.234,5\n", "f.csv:2: ", "holds '1.234,5'"},
      {"x;y\n1;1,234,5\n", "f.csv:2: ", "holds '1,234,5'"},
      {"x,y,x\n", "f.csv:1: ", "two columns are named 'x'"},
      {"x,y\n1,2\n1\n", "f.csv:3: ", "1 fields, the header has 2"},
      {"x,y\n1,2\n1,2,3\n", "f.csv:3: ", "3 fields, the header has 2"},
      {"x,y\n1,2\n3,\n", "f.csv:3: ", "column 'y' is empty"},
      {"x,y\n1,2\n\n3,4\n", "f.csv:3: ", "empty line"}};
  for (const Fault& fault : faults) {
    const std::string file = folder.write("f.csv", fault.content);
    for (const bool numbers : {false, true}) {
      try {
        CsvReader csv(file);
        std::vector<std::string_view> fields;
        std::vector<double> row(2);
        int last_digit = 0;
        while (numbers ? csv.next_numbers({0, 1}, row, last_digit) : csv.next(fields))
          if (!numbers) csv.number(fields, 1);
        ADD_FAILURE() << fault.content;
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr(fault.where)) << fault.content;
        EXPECT_THAT(error.what(), HasSubstr(fault.what)) << fault.content;
      }
    }
  }
  EXPECT_THAT(message_of((folder / "none.csv").string(), read_fields),
              HasSubstr("none.csv: cannot be opened"));
  EXPECT_THAT(message_of(folder.path().string(), read_fields), HasSubstr("is a folder"));
}

TEST(Csv, AMissingColumnTellsThoseThereAre) {
  const tests::Folder folder;
  const CsvReader csv(folder.write("c.csv", "x,y [N]\n"));
  EXPECT_EQ(csv.find("z"), -1);
  EXPECT_EQ(csv.column("y"), 1);
  try {
    csv.column("z");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("c.csv:1: no column 'z': there are x, y"));
  }
}

}  // namespace
}  // namespace struna::ident
