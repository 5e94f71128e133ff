#include "ident/mode_variation.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/SpecialFunctions>

#include "fem/error.hpp"
#include "ident/atomic_file.hpp"
#include "ident/mode_file.hpp"

namespace struna::ident {
namespace {

constexpr double certain = 5.0;  // standard errors within which frequencies may be one mode's

/// Mode `place` of set `set`.
struct Member {
  std::size_t set;
  long place;
};

const Mode& mode_of(const std::vector<ModeSet>& sets, const Member& member) {
  return sets[member.set].modes[static_cast<std::size_t>(member.place)];
}

double distance(const Mode& a, const Mode& b) {
  return std::abs(a.natural_frequency_hz - b.natural_frequency_hz);
}

bool may_be_one(const Mode& a, const Mode& b) {
  const double bandwidth =
      std::max(a.loss_factor * a.natural_frequency_hz, b.loss_factor * b.natural_frequency_hz);
  const double sigma = std::hypot(a.natural_frequency_sigma, b.natural_frequency_sigma);
  return distance(a, b) <= std::max(bandwidth, certain * sigma);
}

/// Place in `modes` of the mode nearest to `mode`.
long nearest(const Mode& mode, const std::vector<Mode>& modes) {
  const auto at = std::min_element(modes.begin(), modes.end(), [&](const Mode& a, const Mode& b) {
    return distance(a, mode) < distance(b, mode);
  });
  return at - modes.begin();
}

void check(const std::vector<ModeSet>& sets) {
  if (sets.size() < 2)
    throw Error(fmt::format("mode_variation: at least two sets of modes are needed, got {}", sets.size()));
  for (std::size_t s = 0; s < sets.size(); ++s) {
    if (sets[s].modes.empty()) throw Error(fmt::format("mode_variation: set {} has no modes", s + 1));
    if (sets[s].damping != sets.front().damping)
      throw Error(fmt::format("mode_variation: set {} has {} damping, set 1 {}: identify both alike", s + 1,
                              fem::to_string(sets[s].damping), fem::to_string(sets.front().damping)));
    for (const Mode& mode : sets[s].modes)
      if (!(mode.natural_frequency_sigma > 0.0 && mode.loss_factor_sigma > 0.0))
        throw Error(
            fmt::format("mode_variation: set {} has no standard errors at {:.6g} Hz: identify it from a "
                        "transfer function "
                        "with sigma or coherence, by circle, multi-mode or auto",
                        s + 1, mode.natural_frequency_hz));
  }
}

/// Groups of members, at most one of each set.
std::vector<std::vector<Member>> same_modes(const std::vector<ModeSet>& sets) {
  std::vector<std::vector<Member>> groups;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    std::vector<Mode> known;  // the first member of each group so far
    for (const std::vector<Member>& group : groups) known.push_back(mode_of(sets, group.front()));
    for (long place = 0; place < static_cast<long>(sets[s].modes.size()); ++place) {
      const Member member{s, place};
      const Mode& mode = mode_of(sets, member);
      const auto group = static_cast<std::size_t>(known.empty() ? 0 : nearest(mode, known));
      const bool mutual =
          !known.empty() && nearest(known[group], sets[s].modes) == place && may_be_one(known[group], mode);
      if (mutual)
        groups[group].push_back(member);
      else
        groups.push_back({member});
    }
  }
  return groups;
}

ModeVariation variation_of(const std::vector<ModeSet>& sets, const std::vector<Member>& members) {
  const long count = static_cast<long>(members.size());
  Eigen::VectorXd frequency(count), frequency_sigma(count), damping(count), damping_sigma(count);
  const double share = sets.front().damping == fem::Damping::viscous ? 0.5 : 1.0;  // zeta = eta/2
  ModeVariation variation;
  variation.place.assign(sets.size(), -1);
  for (long k = 0; k < count; ++k) {
    const Member& member = members[static_cast<std::size_t>(k)];
    const Mode& mode = mode_of(sets, member);
    variation.place[member.set] = member.place;
    frequency[k] = mode.natural_frequency_hz;
    frequency_sigma[k] = mode.natural_frequency_sigma;
    damping[k] = share * mode.loss_factor;
    damping_sigma[k] = share * mode.loss_factor_sigma;
    for (const ModeFlag flag : mode.flags)
      if (std::find(variation.flags.begin(), variation.flags.end(), flag) == variation.flags.end())
        variation.flags.push_back(flag);
  }
  variation.frequency = ident::variation_of(frequency, frequency_sigma);
  variation.damping = ident::variation_of(damping, damping_sigma);
  return variation;
}

}  // namespace

Variation variation_of(const Eigen::VectorXd& value, const Eigen::VectorXd& sigma) {
  if (value.size() == 0 || value.size() != sigma.size() || !(sigma.array() > 0.0).all())
    throw Error("variation_of: values with a positive standard error each are needed");
  const double freedom = static_cast<double>(value.size() - 1);
  // About the first value: frequencies differ in their sixth digit.
  const Eigen::ArrayXd x = value.array() - value[0];
  const Eigen::ArrayXd precision = sigma.array().square().inverse();
  const double total = precision.sum();
  const double fixed_mean = (precision * x).sum() / total;
  const double chi_squared = (precision * (x - fixed_mean).square()).sum();

  Variation variation;
  variation.largest = x.maxCoeff() - x.minCoeff();
  double between = 0.0;
  if (freedom > 0.0) {
    variation.probability = Eigen::numext::igammac(0.5 * freedom, 0.5 * chi_squared);
    between = std::max(0.0, (chi_squared - freedom) / (total - precision.square().sum() / total));
  }
  const Eigen::ArrayXd weight = (sigma.array().square() + between).inverse();
  variation.between = std::sqrt(between);
  variation.mean = value[0] + (weight * x).sum() / weight.sum();
  variation.mean_sigma = 1.0 / std::sqrt(weight.sum());
  return variation;
}

long ModeVariation::sets() const {
  return std::count_if(place.begin(), place.end(), [](long at) { return at >= 0; });
}

std::vector<ModeVariation> mode_variation(const std::vector<ModeSet>& sets) {
  check(sets);
  std::vector<ModeVariation> modes;
  for (const std::vector<Member>& members : same_modes(sets)) modes.push_back(variation_of(sets, members));
  std::sort(modes.begin(), modes.end(), [](const ModeVariation& a, const ModeVariation& b) {
    return a.frequency.mean < b.frequency.mean;
  });
  return modes;
}

void write_mode_variation(const std::vector<ModeVariation>& modes, fem::Damping damping,
                          const std::string& file) {
  std::string text;
  for (const auto& [name, unit] :
       {std::pair("natural_frequency", "Hz"),
        std::pair(damping == fem::Damping::viscous ? "damping_ratio" : "loss_factor", "-")})
    text += fmt::format("{0} [{1}],{0}_sigma [{1}],{0}_between [{1}],{0}_largest [{1}],{0}_probability [-],",
                        name, unit);
  text += "sets [-],flags\n";
  for (const ModeVariation& mode : modes) {
    for (const Variation& v : {mode.frequency, mode.damping})
      text += fmt::format("{},{},{},{},{},", v.mean, v.mean_sigma, v.between, v.largest, v.probability);
    text += fmt::format("{},{}\n", mode.sets(), flag_words(mode.flags));
  }
  write_atomically(file, text);
}

}  // namespace struna::ident
