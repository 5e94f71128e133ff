#include "apps/limit_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>

namespace struna::apps {
namespace {

constexpr std::size_t most_axes = 3;

void count_trial(const LimitTrial& trial, LimitCount& count) {
  const bool flagged = !trial.flags.empty();
  switch (outcome(trial)) {
    case Outcome::right:
      ++count.right;
      count.right_flagged += flagged;
      break;
    case Outcome::uncertain:
      ++count.uncertain;
      break;
    case Outcome::wrong:
      ++count.wrong;
      count.wrong_flagged += flagged;
      break;
    case Outcome::refused:
      ++count.refused;
  }
}

std::string field(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}

}  // namespace

Outcome outcome(const LimitTrial& trial) {
  if (trial.refused) return Outcome::refused;
  if (!std::isfinite(trial.error)) return Outcome::wrong;
  if (!std::isfinite(trial.sigma)) return trial.error > trial.tolerance ? Outcome::wrong : Outcome::right;
  const bool far = trial.error > 5.0 * trial.sigma;
  const bool beyond_both = trial.error > 3.0 * trial.sigma && trial.error > trial.tolerance;
  if (far || beyond_both) return Outcome::wrong;
  return trial.error > trial.tolerance ? Outcome::uncertain : Outcome::right;
}

std::string to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::right:
      return "right";
    case Outcome::uncertain:
      return "uncertain";
    case Outcome::wrong:
      return "wrong";
    case Outcome::refused:
      return "refused";
  }
  return "";
}

double LimitCount::flagged_share() const {
  return wrong > 0 ? static_cast<double>(wrong_flagged) / static_cast<double>(wrong) : 1.0;
}

double LimitCount::false_alarm_share() const {
  return right > 0 ? static_cast<double>(right_flagged) / static_cast<double>(right) : 0.0;
}

std::string LimitCount::flagged_text() const {
  return wrong > 0 ? fmt::format("{:.1f} %", 100.0 * flagged_share()) : "–";
}

std::string LimitCount::false_alarm_text() const {
  return right > 0 ? fmt::format("{:.1f} %", 100.0 * false_alarm_share()) : "–";
}

LimitCount count_of(const LimitMap& map) {
  LimitCount count;
  for (const auto& trial : map.trials) count_trial(trial, count);
  return count;
}

LimitCount count_at(const LimitMap& map, const std::vector<double>& at) {
  LimitCount count;
  for (const auto& trial : map.trials)
    if (trial.at == at) count_trial(trial, count);
  return count;
}

std::string sentence_of(const LimitMap& map) {
  std::string text = fmt::format("{}; noticed by {}; then {}.", map.fails, map.sign, map.then);
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string limits_csv(const std::vector<LimitMap>& maps) {
  std::string text =
      "map,parameter_1,value_1,parameter_2,value_2,parameter_3,value_3,seed,quantity,error,sigma,tolerance,"
      "outcome,flags\n";
  for (const auto& map : maps) {
    for (const auto& trial : map.trials) {
      text += map.name;
      for (std::size_t k = 0; k < most_axes; ++k)
        text += k < map.axes.size() ? fmt::format(",{},{:g}", map.axes[k].name, trial.at[k]) : ",,";
      text += fmt::format(",{},{},{},{},{},{},{}\n", trial.seed, map.quantity, field(trial.error),
                          field(trial.sigma), field(trial.tolerance), to_string(outcome(trial)), trial.flags);
    }
  }
  return text;
}

std::vector<unsigned> LimitRun::draws(int usual) const {
  std::vector<unsigned> all(static_cast<std::size_t>(seeds > 0 ? seeds : usual));
  std::iota(all.begin(), all.end(), static_cast<unsigned>(first_seed));
  return all;
}

LimitAxis LimitRun::axis(std::string name, std::vector<double> values) const {
  LimitAxis thinned{std::move(name), {}};
  const auto step = static_cast<std::size_t>(every);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (i % step == 0 || i + 1 == values.size()) thinned.values.push_back(values[i]);
  return thinned;
}

bool told(const std::vector<std::string>& warnings, const std::string& words) {
  return std::any_of(warnings.begin(), warnings.end(),
                     [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
}

void for_each_place(const std::vector<LimitAxis>& axes,
                    const std::function<void(const std::vector<double>&)>& visit) {
  std::vector<std::size_t> index(axes.size(), 0);
  std::vector<double> at(axes.size());
  for (;;) {
    for (std::size_t k = 0; k < axes.size(); ++k) at[k] = axes[k].values[index[k]];
    visit(at);
    std::size_t k = 0;
    while (k < axes.size() && ++index[k] == axes[k].values.size()) index[k++] = 0;
    if (k == axes.size()) return;
  }
}

}  // namespace struna::apps
