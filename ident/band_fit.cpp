#include "ident/band_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "ident/group_fit.hpp"
#include "ident/mode_flags.hpp"
#include "ident/resonance_search.hpp"

namespace struna::ident {
namespace {

constexpr double settled = 0.1;  // standard errors, or 1e-4 bandwidths: the last round moves no mode farther
constexpr double lack_of_fit =
    2.0;  // chi-square per degree of freedom from which on the model's own error counts
constexpr double structured = 4.0;  // lines worth one from which on the residual is no noise
constexpr double narrower_windows[] = {8.0, 5.0, 3.0};  // bandwidths
constexpr double first_window = 5.0;                    // of the first round, which only improves the start
constexpr double most_scatter = 0.1;                    // beyond noise, of the radius
constexpr double untouched = 1e-3;  // bandwidths: a group whose modes moved less is not fitted again
// Of Schwarz's penalty for a pole outside the band, which nobody claims: near Akaike's, as its tail biases
// the last mode before it is sure (IEEE Trans. Autom. Control 19 (1974) 716).
constexpr double background_part = 0.3;
constexpr int most_rounds = 8, most_trials = 3, most_weighings = 4, fresh_rounds = 3;
constexpr int most_iterations = 20;  // of one fit
constexpr double tolerance = 0.01;   // of one fit, in standard errors

// Constants from the line next to the resonance: good enough to take a distant mode's share off.
void complete_start(const TransferFunction& tf, Mode& mode, fem::Damping damping) {
  if (mode.modal_constant.size() == static_cast<long>(tf.outputs.size())) return;
  long nearest = 0;
  (tf.frequency_hz.array() - mode.natural_frequency_hz).abs().minCoeff(&nearest);
  const auto g = pole_function(pole_of(mode), 2.0 * std::numbers::pi * tf.frequency_hz(nearest), damping);
  mode.modal_constant.resize(static_cast<long>(tf.outputs.size()));
  for (std::size_t k = 0; k < tf.outputs.size(); ++k)
    mode.modal_constant(static_cast<long>(k)) = tf.outputs[k].value(nearest) / g;
}

// Whether a round left the modes where the one before had them.
bool same(const std::vector<Mode>& before, const std::vector<Mode>& after) {
  if (before.size() != after.size()) return false;
  for (std::size_t r = 0; r < after.size(); ++r)
    if (std::abs(after[r].natural_frequency_hz - before[r].natural_frequency_hz) >
            std::max(settled * after[r].natural_frequency_sigma, 1e-4 * bandwidth_hz(pole_of(after[r]))) ||
        std::abs(after[r].loss_factor - before[r].loss_factor) >
            std::max(settled * after[r].loss_factor_sigma, 1e-4 * after[r].loss_factor))
      return false;
  return true;
}

std::vector<Pole> joined(const std::vector<Pole>& target, const std::vector<Pole>& company) {
  std::vector<Pole> all = target;
  all.insert(all.end(), company.begin(), company.end());
  return all;
}

// A group's fit, its poles dropped and added until nothing objects and nothing is missing.
struct GroupResult {
  std::vector<Mode> modes;
  std::vector<RejectedCandidate> rejected;
  std::vector<Pole> banned;  // not to be tried again
  bool changed = false;
  double lack = 0.0;  // of the fit, before the model's own error was weighed in
  double line_correlation = 1.0;
};

// What the lines tell of a pole beside its values.
struct Noted {
  Pole pole;
  bool is_poor = false;  // the lines lie off its circle
  SecondPole second;
};

class GroupRefiner {
 public:
  GroupRefiner(TransferFunction window, const ModeGroup& group, const Span& band,
               const std::vector<Mode>& start, const PoleFitOptions& options,
               const std::vector<Pole>& candidates, std::vector<Pole>& failed)
      : window_(std::move(window)),
        noise_(window_),
        group_(group),
        band_(band),
        start_(start),
        options_(options),
        candidates_(candidates),
        failed_(failed),
        fit_(window_, group.outside, band, options) {}
  GroupRefiner(const GroupRefiner&) = delete;  // fit_ points to window_
  GroupRefiner& operator=(const GroupRefiner&) = delete;

  GroupResult run(bool search) {
    target_ = group_.target;
    if (!fit_.can_fit(group_.company.size())) return std::move(result_);
    while (!target_.empty() && !fit_.can_fit(target_.size() + group_.company.size()))
      reject(target_.size() - 1, too_few_lines);
    refit();
    drop();
    if (search) add();
    result_.lack = fit_.lack();
    result_.line_correlation = fit_.result().line_correlation;
    note_what_noise_tells();
    weigh_model_error();
    drop();
    if (search) drop_what_is_no_circle();
    for (long r = 0; r < count(); ++r) {
      Mode mode = to_mode(fit_.result(), r, options_.damping);
      const SecondPole second = fit_.second_pole(r);
      const Noted noted = noted_of(target_[static_cast<std::size_t>(r)]).value_or(Noted{{}, false, second});
      if (fit_.is_double(r) || second.noticed || noted.second.noticed)
        add_flag(mode, ModeFlag::double_mode);
      else if (noted.second.hinted)
        add_flag(mode, ModeFlag::may_be_two);
      if (noted.is_poor) add_flag(mode, ModeFlag::poor_circle);
      mode.resolves_from = noted.second.resolves_from;
      result_.modes.push_back(std::move(mode));
    }
    return std::move(result_);
  }

 private:
  long count() const { return static_cast<long>(target_.size()); }
  void refit() {
    fit_.fit(joined(target_, group_.company));
    take_over();
  }
  // By the noise alone: once the model's own error is weighed in, every circle looks as it should, and in an
  // output where two modes nearly cancel nothing tells them from it.
  void note_what_noise_tells() {
    for (long r = 0; r < count(); ++r)
      noted_.push_back({target_[static_cast<std::size_t>(r)], fit_.is_poor(r), fit_.second_pole(r)});
  }
  std::optional<Noted> noted_of(const Pole& pole) const {
    std::optional<Noted> nearest;
    double least = 0.5;  // bandwidths
    for (const Noted& noted : noted_) {
      const double distance =
          std::abs(pole.natural_frequency_hz - noted.pole.natural_frequency_hz) / bandwidth_hz(noted.pole);
      if (distance >= least) continue;
      nearest = noted;
      least = distance;
    }
    return nearest;
  }
  // Last of all, as a mode that is still missing would spoil its neighbours' circles. Modes whose own circle
  // was sound stay, and candidates: what a strong neighbour's fit leaves is much beside a weak mode's radius.
  void drop_what_is_no_circle() {
    const auto scatter_of = [&](long r) {
      return seen(target_[static_cast<std::size_t>(r)]) ? 0.0 : fit_.scatter_of(r);
    };
    while (count() > 0) {
      long worst = 0;
      for (long r = 1; r < count(); ++r)
        if (scatter_of(r) > scatter_of(worst)) worst = r;
      const double scatter = scatter_of(worst);
      if (scatter < most_scatter) return;
      failed_.push_back(target_[static_cast<std::size_t>(worst)]);
      result_.banned.push_back(target_[static_cast<std::size_t>(worst)]);
      reject(static_cast<std::size_t>(worst),
             fmt::format("no circle: scatter {:.0f} % of the radius", 100.0 * scatter));
      refit();
    }
  }
  bool seen(const Pole& pole) const {
    const auto is_at = [&](const Pole& other) {
      return std::abs(other.natural_frequency_hz - pole.natural_frequency_hz) < 0.5 * bandwidth_hz(other);
    };
    return std::any_of(candidates_.begin(), candidates_.end(), is_at) ||
           std::any_of(start_.begin(), start_.end(),
                       [&](const Mode& mode) { return !mode.circles.empty() && is_at(pole_of(mode)); });
  }
  void weigh_model_error() {
    for (int pass = 0; pass < most_weighings && fit_.lack() > lack_of_fit; ++pass) {
      ident::weigh_model_error(noise_, fit_.result().residual, window_);
      refit();
    }
  }
  void take_over() { target_.assign(fit_.result().poles.begin(), fit_.result().poles.begin() + count()); }
  void reject(std::size_t r, const std::string& reason) {
    result_.rejected.push_back({target_[r].natural_frequency_hz, reason});
    target_.erase(target_.begin() + static_cast<long>(r));
    result_.changed = true;
  }

  void drop() {
    while (const auto worst = fit_.worst(count())) {
      failed_.push_back(target_[static_cast<std::size_t>(*worst)]);
      reject(static_cast<std::size_t>(*worst), fit_.objection(*worst));
      refit();
    }
  }

  // In the band, or outside where less will do.
  std::optional<ResidualPole> strongest_candidate() const {
    const Span& territory = group_.territory;
    std::optional<ResidualPole> strongest;
    const auto search = [&](double lo_hz, double hi_hz, double part) {
      if (lo_hz >= hi_hz) return;
      const auto found =
          strongest_pole(window_, fit_.result().residual, lo_hz, hi_hz, failed_, part * fit_.penalty());
      if (found && (!strongest || found->gain > strongest->gain)) strongest = found;
    };
    search(std::max(territory.lo_hz, band_.lo_hz), std::min(territory.hi_hz, band_.hi_hz), 1.0);
    search(territory.lo_hz, band_.lo_hz, background_part);
    search(band_.hi_hz, territory.hi_hz, background_part);
    return strongest;
  }

  // A given candidate (gain not known: 0) that is neither a mode nor refused yet, else the strongest pole of
  // the residual.
  std::optional<ResidualPole> next_to_try() const {
    const auto near = [](const std::vector<Pole>& poles, const Pole& pole) {
      return std::any_of(poles.begin(), poles.end(), [&](const Pole& other) {
        return std::abs(other.natural_frequency_hz - pole.natural_frequency_hz) <
               0.5 * std::max(bandwidth_hz(other), bandwidth_hz(pole));
      });
    };
    for (const Pole& pole : candidates_)
      if (group_.territory.holds(pole.natural_frequency_hz) && !near(target_, pole) &&
          !near(group_.company, pole) && !near(failed_, pole))
        return ResidualPole{pole, 0.0};
    return strongest_candidate();
  }

  void add() {
    int trials = 0;
    while (trials < most_trials) {
      const auto candidate = next_to_try();
      if (!candidate || !fit_.can_fit(target_.size() + group_.company.size() + 1)) return;
      if (candidate->gain > 0.0) ++trials;  // each given candidate has its own
      std::vector<Pole> more = target_;
      more.push_back(candidate->pole);
      GroupFit trial(window_, group_.outside, band_, options_);
      trial.fit(joined(more, group_.company));
      const double gain = fit_.result().chi_square - trial.result().chi_square;
      const double f = trial.result().poles[target_.size()].natural_frequency_hz;
      const bool refused_before = std::any_of(failed_.begin(), failed_.end(), [&](const Pole& other) {
        return std::abs(other.natural_frequency_hz - f) < 0.1 * bandwidth_hz(other);
      });
      const double part = band_.holds(f) ? 1.0 : background_part;
      if (refused_before || !group_.territory.holds(f) || gain < part * trial.penalty() ||
          trial.worst(count() + 1)) {
        failed_.push_back(candidate->pole);
        continue;
      }
      target_.push_back(candidate->pole);
      fit_ = trial;
      take_over();
      result_.changed = true;
      trials = 0;
    }
  }

  TransferFunction window_;
  TransferFunction noise_;  // the window with the noise's own sigma
  const ModeGroup& group_;
  Span band_;
  const std::vector<Mode>& start_;
  PoleFitOptions options_;
  const std::vector<Pole>& candidates_;
  std::vector<Pole>& failed_;  // candidates that a trial has refused
  GroupFit fit_;
  std::vector<Pole> target_;
  std::vector<Noted> noted_;
  GroupResult result_;
};

// In the widest window in which the model explains the lines; where it does in none, in the narrowest.
GroupResult refine(const TransferFunction& tf, const ModeGroup& group, const std::vector<Mode>& modes,
                   const std::vector<Mode>& start, const PoleFitOptions& options,
                   const std::vector<Pole>& candidates, bool search, std::vector<Pole>& failed) {
  const LineBand band = band_of(tf);
  const auto refined_in = [&](const ModeGroup& window) {
    return GroupRefiner(lines_of(tf, window, options.damping), window, band, start, options, candidates,
                        failed)
        .run(search);
  };
  if (!search) return refined_in(with_window(group, modes, band, first_window));
  GroupResult result = refined_in(group);
  if (group.target.empty()) return result;
  for (const double bandwidths : narrower_windows) {
    // What was found in the wider window is taken up in the next round.
    if (result.changed || (result.lack < lack_of_fit && result.line_correlation < structured)) break;
    result = refined_in(with_window(group, modes, band, bandwidths));
  }
  return result;
}

// What a group was and what came of it, to be taken up again while its modes stay.
struct Done {
  ModeGroup group;
  GroupResult result;
};

bool stays(const Pole& before, const Pole& now) {
  return std::abs(now.natural_frequency_hz - before.natural_frequency_hz) < untouched * bandwidth_hz(now) &&
         std::abs(now.loss_factor - before.loss_factor) < untouched * now.loss_factor;
}

bool stays(const Done& done, const ModeGroup& now) {
  const ModeGroup& before = done.group;
  if (done.result.modes.size() != now.target.size() || before.company.size() != now.company.size() ||
      before.outside.size() != now.outside.size())
    return false;
  for (std::size_t r = 0; r < now.target.size(); ++r)
    if (!stays(pole_of(done.result.modes[r]), now.target[r])) return false;
  for (std::size_t r = 0; r < now.company.size(); ++r)
    if (!stays(before.company[r], now.company[r])) return false;
  for (std::size_t r = 0; r < now.outside.size(); ++r)
    if (!stays(pole_of(before.outside[r]), pole_of(now.outside[r]))) return false;
  return true;
}

// Poles that only stand for what lies outside the band.
std::string objection_at_edge(const Mode& mode, const std::vector<Mode>& start, const Span& band) {
  const double f = mode.natural_frequency_hz, bandwidth = bandwidth_hz(pole_of(mode));
  if (!band.holds(f)) return "outside the band";
  if (f - bandwidth > band.lo_hz && f + bandwidth < band.hi_hz) return "";
  const bool seen = std::any_of(start.begin(), start.end(), [&](const Mode& other) {
    return std::abs(other.natural_frequency_hz - f) < bandwidth;
  });
  return seen ? "" : "within a bandwidth of the band's end and no peak: it may be a trend";
}

}  // namespace

BandFit fit_band(const TransferFunction& tf, const std::vector<Mode>& start, const BandFitOptions& options) {
  const LineBand band = band_of(tf);
  BandFit result;
  result.modes = start;
  for (Mode& mode : result.modes) complete_start(tf, mode, options.damping);
  sort_by_frequency(result.modes);
  std::vector<Pole> failed, banned;
  PoleFitOptions fit_options;
  fit_options.damping = options.damping;
  fit_options.sigma_known = options.sigma_known;
  fit_options.max_iterations = most_iterations;
  fit_options.tolerance = tolerance;
  std::vector<Done> searched;
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<Mode> modes;
    std::vector<Done> done;
    bool changed = false;
    // Poles are added once the others' shares are known well.
    const bool search = options.search_residual && (round > 0 || start.empty());
    for (const ModeGroup& group : group_modes(result.modes, band)) {
      if (group.target.empty() && !search) continue;
      const auto known = std::find_if(searched.begin(), searched.end(),
                                      [&](const Done& candidate) { return stays(candidate, group); });
      if (known != searched.end()) {
        done.push_back(*known);
      } else {
        done.push_back(
            {group, refine(tf, group, result.modes, start, fit_options, options.candidates, search, failed)});
        const GroupResult& refined = done.back().result;
        changed = changed || refined.changed;
        result.rejected.insert(result.rejected.end(), refined.rejected.begin(), refined.rejected.end());
        banned.insert(banned.end(), refined.banned.begin(), refined.banned.end());
      }
      const auto& found = done.back().result.modes;
      modes.insert(modes.end(), found.begin(), found.end());
    }
    sort_by_frequency(modes);
    const bool settled_down = round > 0 && !changed && same(result.modes, modes);
    result.modes = std::move(modes);
    if (settled_down) break;
    if (changed && round < fresh_rounds) failed = banned;
    if (search) searched = std::move(done);
  }
  std::erase_if(result.modes, [&](const Mode& mode) {
    const std::string reason = objection_at_edge(mode, start, band);
    if (!reason.empty()) result.rejected.push_back({mode.natural_frequency_hz, reason});
    return !reason.empty();
  });
  return result;
}

}  // namespace struna::ident
