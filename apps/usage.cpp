#include "apps/usage.hpp"

#include <charconv>
#include <cmath>
#include <string_view>

namespace struna::apps {
namespace {

/// A finite number that takes the whole text.
bool read_number(std::string_view text, double& value) {
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  return fault == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

}  // namespace

Band parse_band(const std::string& text) {
  const std::string_view view = text;
  const std::size_t colon = view.find(':');
  Band band;
  const bool numbers = colon != std::string_view::npos && read_number(view.substr(0, colon), band.lo_hz) &&
                       read_number(view.substr(colon + 1), band.hi_hz);
  if (!numbers) throw UsageError("a band is LO:HI in Hz, such as 10:1000, got '" + text + "'");
  if (band.lo_hz < 0.0 || band.lo_hz >= band.hi_hz) {
    throw UsageError("a band LO:HI needs 0 <= LO < HI, got '" + text + "'");
  }
  return band;
}

}  // namespace struna::apps
