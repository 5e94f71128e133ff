#include "apps/usage.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
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

/// Whether two names lead to one file, there already or not. A terminal or a pipe is none.
bool same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code fault;
  if (fs::exists(a, fault)) return fs::is_regular_file(a, fault) && fs::equivalent(a, b, fault);
  return fs::weakly_canonical(a, fault) == fs::weakly_canonical(b, fault);
}

}  // namespace

std::string small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

void refuse_overwriting(const std::vector<std::pair<std::string, std::string>>& written,
                        const std::vector<std::string>& read) {
  for (std::size_t i = 0; i < written.size(); ++i) {
    const auto& [option, file] = written[i];
    if (file.empty()) continue;
    for (const auto& input : read) {
      if (same_file(file, input))
        throw UsageError(option + " " + file + ": would overwrite its own input" +
                         (input == file ? "" : " " + input) + "; give another name");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (same_file(file, written[j].second))
        throw UsageError(option + " " + file + ": " + written[j].first +
                         " writes to the same file; give another name");
    }
  }
}

std::string refusal_of_hz(const std::string& text) {
  double hz = 0.0;
  return read_number(text, hz) && hz > 0.0 ? "" : "must be above 0 Hz, got " + text;
}

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
