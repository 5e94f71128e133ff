#pragma once

#include <string>
#include <string_view>

namespace struna::ident {

/// What a channel measures.
enum class Quantity { time, displacement, velocity, acceleration, force, unknown };

/// "m", "m/s", "m/s^2", "N", "s"; "" for unknown.
std::string si_unit(Quantity quantity);

/// A unit as written in a column header, and the factor that takes its values to SI.
struct Unit {
  Quantity quantity = Quantity::unknown;
  double to_si = 1.0;
  std::string si;  ///< "m", "m/s", "m/s^2", "N", "s"
};

/// Reads "mm/s", "um", "g", "kN", "lbf", "ms" … Throws Error naming the unit and those understood.
Unit parse_unit(const std::string& text);

/// Splits a header field `name [unit]`; the unit is empty when there are no brackets. Spaces around both and
/// quotes around the whole are taken off.
struct ColumnHeader {
  std::string name;
  std::string unit;
};
ColumnHeader parse_column_header(const std::string& field);

/// The text without blanks (spaces, tabs) at its ends.
std::string_view trimmed(std::string_view text);

}  // namespace struna::ident
