#include "ident/units.hpp"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

struct UnitEntry {
  const char* text;
  Quantity quantity;
  double to_si;
};

constexpr double standard_gravity = 9.80665;     // [m/s^2] exact, 3rd CGPM 1901
constexpr double pound_force = 4.4482216152605;  // [N] exact: 0.45359237 kg times standard gravity
constexpr double inch = 0.0254;                  // [m] exact

// The words of a quantity stand together, SI first; other spellings of a unit follow it.
constexpr std::array units = {
    UnitEntry{"s", Quantity::time, 1.0},
    UnitEntry{"ms", Quantity::time, 1e-3},
    UnitEntry{"us", Quantity::time, 1e-6},
    UnitEntry{"µs", Quantity::time, 1e-6},
    UnitEntry{"μs", Quantity::time, 1e-6},
    UnitEntry{"m", Quantity::displacement, 1.0},
    UnitEntry{"cm", Quantity::displacement, 1e-2},
    UnitEntry{"mm", Quantity::displacement, 1e-3},
    UnitEntry{"um", Quantity::displacement, 1e-6},
    UnitEntry{"µm", Quantity::displacement, 1e-6},
    UnitEntry{"μm", Quantity::displacement, 1e-6},
    UnitEntry{"nm", Quantity::displacement, 1e-9},
    UnitEntry{"in", Quantity::displacement, inch},
    UnitEntry{"m/s", Quantity::velocity, 1.0},
    UnitEntry{"mm/s", Quantity::velocity, 1e-3},
    UnitEntry{"um/s", Quantity::velocity, 1e-6},
    UnitEntry{"in/s", Quantity::velocity, inch},
    UnitEntry{"m/s^2", Quantity::acceleration, 1.0},
    UnitEntry{"m/s2", Quantity::acceleration, 1.0},
    UnitEntry{"m/s²", Quantity::acceleration, 1.0},
    UnitEntry{"mm/s^2", Quantity::acceleration, 1e-3},
    UnitEntry{"g", Quantity::acceleration, standard_gravity},
    UnitEntry{"N", Quantity::force, 1.0},
    UnitEntry{"mN", Quantity::force, 1e-3},
    UnitEntry{"kN", Quantity::force, 1e3},
    UnitEntry{"lbf", Quantity::force, pound_force},
};

std::string understood() {
  std::vector<std::string_view> words;
  for (const UnitEntry& unit : units) words.push_back(unit.text);
  return fmt::format("{}", fmt::join(words, " "));
}

}  // namespace

std::string si_unit(Quantity quantity) {
  for (const UnitEntry& unit : units)
    if (unit.quantity == quantity) return unit.text;
  return "";
}

Unit parse_unit(const std::string& text) {
  for (const UnitEntry& unit : units)
    if (text == unit.text) return {unit.quantity, unit.to_si, si_unit(unit.quantity)};
  throw Error(fmt::format("unknown unit '{}': understood are {}", text, understood()));
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

ColumnHeader parse_column_header(const std::string& field) {
  std::string_view text = trimmed(field);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    text = trimmed(text.substr(1, text.size() - 2));
  const auto open = text.rfind('[');
  if (open == std::string_view::npos || text.back() != ']') return {std::string(text), ""};
  return {std::string(trimmed(text.substr(0, open))),
          std::string(trimmed(text.substr(open + 1, text.size() - open - 2)))};
}

}  // namespace struna::ident
