#include "apps/usage.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace struna::apps {
namespace {

/// A finite number that takes the whole text.
bool read_number(std::string_view text, double& value) {
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  return fault == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

/// LO:HI; none when it is not two numbers.
std::optional<std::pair<double, double>> read_pair(std::string_view text) {
  const std::size_t colon = text.find(':');
  std::pair<double, double> pair;
  const bool numbers = colon != std::string_view::npos && read_number(text.substr(0, colon), pair.first) &&
                       read_number(text.substr(colon + 1), pair.second);
  if (!numbers) return std::nullopt;
  return pair;
}

}  // namespace

Band parse_band(const std::string& text) {
  const auto pair = read_pair(text);
  if (!pair) throw UsageError("a band is LO:HI in Hz, such as 10:1000, got '" + text + "'");
  if (pair->first < 0.0 || pair->first >= pair->second) {
    throw UsageError("a band LO:HI needs 0 <= LO < HI, got '" + text + "'");
  }
  return {pair->first, pair->second};
}

std::pair<double, double> parse_modulus_range(const std::string& text) {
  const auto pair = read_pair(text);
  if (!pair || pair->first <= 0.0 || pair->first >= pair->second) {
    throw UsageError("--modulus-range: LO:HI in Pa with 0 < LO < HI, such as 1e10:3e11, got '" + text + "'");
  }
  return *pair;
}

}  // namespace struna::apps
