#include "ident/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

struct Case {
  const char* text;
  Quantity quantity;
  double to_si;
};

// Factors by definition: standard gravity 9.80665 m/s^2, pound 0.45359237 kg, inch 25.4 mm.
TEST(Units, EveryUnitOfTheInterfaceHasItsFactorToSi) {
  const Case cases[] = {{"m", Quantity::displacement, 1.0},
                        {"mm", Quantity::displacement, 1e-3},
                        {"um", Quantity::displacement, 1e-6},
                        {"µm", Quantity::displacement, 1e-6},
                        {"m/s", Quantity::velocity, 1.0},
                        {"mm/s", Quantity::velocity, 1e-3},
                        {"m/s^2", Quantity::acceleration, 1.0},
                        {"mm/s^2", Quantity::acceleration, 1e-3},
                        {"g", Quantity::acceleration, 9.80665},
                        {"N", Quantity::force, 1.0},
                        {"mN", Quantity::force, 1e-3},
                        {"kN", Quantity::force, 1e3},
                        {"lbf", Quantity::force, 0.45359237 * 9.80665},
                        {"s", Quantity::time, 1.0},
                        {"ms", Quantity::time, 1e-3},
                        {"us", Quantity::time, 1e-6}};
  for (const Case& c : cases) {
    const Unit unit = parse_unit(c.text);
    EXPECT_EQ(unit.quantity, c.quantity) << c.text;
    EXPECT_DOUBLE_EQ(unit.to_si, c.to_si) << c.text;
    EXPECT_EQ(unit.si, si_unit(c.quantity)) << c.text;
  }
}

TEST(Units, AnUnknownUnitIsRefusedWithThoseUnderstood) {
  for (const char* text : {"", "V", "M", "kn", "furlong", " m", "m/s^3"}) {
    try {
      parse_unit(text);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("'" + std::string(text) + "'"));
      EXPECT_THAT(error.what(), testing::HasSubstr("lbf"));
    }
  }
}

TEST(Units, AColumnHeaderIsANameAndAUnitInBrackets) {
  const auto expect = [](const char* field, const char* name, const char* unit) {
    const ColumnHeader header = parse_column_header(field);
    EXPECT_EQ(header.name, name) << field;
    EXPECT_EQ(header.unit, unit) << field;
  };
  expect("force [N]", "force", "N");
  expect("  force_x[kN] ", "force_x", "kN");
  expect("\"time [ s ]\"", "time", "s");
  expect("flags", "flags", "");
  expect("a [b] c", "a [b] c", "");
  expect("acceleration [m/s^2]", "acceleration", "m/s^2");
  expect("", "", "");
}

}  // namespace
}  // namespace struna::ident
