#include "fem/accuracy_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "fem/contact_trial.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

constexpr double in_step = 5e-3;  ///< before the first touch, trials step as the run does from here on [s]
constexpr double share = 0.5;     ///< of the tolerance that a trial may use up
constexpr int most_levels = 5;
constexpr int reference_levels = 3;  ///< between a trial and its reference, each a quarter of the tolerance
/// Own error of a reference over its distance from a trial 64 times looser, where errors fall with the 0.4th
/// power of the tolerance: 64^-0.4/(1 - 64^-0.4). Slower they did not fall where trajectories part within the
/// window (docs/modal_stepping.md).
constexpr double reference_share = 0.23;
constexpr double least_tolerance = 1e-8;  ///< of references that are tightened: below, rounding shows

/// Offsets of all points at the looks from the first touch on.
struct Trial {
  std::vector<Eigen::Vector2d> path;
  double from = 0.0, until = 0.0;  ///< [s]
  double largest = 0.0;            ///< displacement [m]
  long steps = 0;
  int modes = 0;
};

struct TrialSetup {
  const std::vector<ModalBody>& bodies;
  const std::vector<ContactPoint>& points;
  const PrescribedMotion& motion;
  double duration;
  bool settle;
  const std::function<bool(double)>& progress;
  double interval;  ///< between looks [s]
};

/// Runs to `from`, or to the first touch where `from` is negative, and records the window beyond.
Trial run_trial(const TrialSetup& setup, const ModalSteppingOptions& options, double from) {
  ModalStepper stepper(setup.bodies, setup.points, setup.motion, options);
  if (setup.settle) stepper.settle();
  const int points = static_cast<int>(setup.points.size());
  Trial trial;
  trial.from = from;
  const long last = static_cast<long>(std::floor(setup.duration / setup.interval));
  for (long look = 0; look <= last; ++look) {
    const double t = static_cast<double>(look) * setup.interval;
    const bool stop = look % 256 == 0;  // now and then, to be asked whether to go on
    if (t < trial.from - in_step && !stop) continue;
    if (stop && setup.progress && !setup.progress(t)) throw TrialInterrupted();
    stepper.advance(t);
    if (t < trial.from) continue;
    if (trial.from < 0.0) {
      if (!touching(stepper, setup.points.size())) continue;
      trial.from = t;
    }
    if (t > trial.from + checked_beyond_touch) break;
    for (int i = 0; i < points; ++i) trial.path.push_back(stepper.offset(i));
    trial.until = t;
  }
  const StepReport& report = stepper.report();
  trial.largest = report.largest_displacement;
  trial.steps = report.free_steps + report.contact_steps;
  trial.modes = report.modes;
  return trial;
}

/// Largest distance of any point at a look, over the largest displacement.
double distance_at(const Trial& trial, const Trial& reference, std::size_t first, std::size_t points) {
  double worst = 0.0;
  for (std::size_t i = first; i < first + points; ++i)
    worst = std::max(worst, (trial.path[i] - reference.path[i]).cwiseAbs().maxCoeff());
  return reference.largest > 0.0 ? worst / reference.largest : 0.0;
}

double distance(const Trial& trial, const Trial& reference) {
  return distance_at(trial, reference, 0, std::min(trial.path.size(), reference.path.size()));
}

/// The last look up to which a trial keeps within `limit` of the reference [s].
double within_until(const TrialSetup& setup, const Trial& trial, const Trial& reference, double limit) {
  const std::size_t points = setup.points.size();
  const std::size_t looks = std::min(trial.path.size(), reference.path.size()) / points;
  std::size_t kept = 0;
  while (kept < looks && distance_at(trial, reference, kept * points, points) <= limit) ++kept;
  return std::max(0.0, reference.from + setup.interval * (static_cast<double>(kept) - 1.0));
}

double highest_mode(const std::vector<ModalBody>& bodies) {
  double highest = 0.0;
  for (const ModalBody& body : bodies) {
    if (body.poles.pole.size() > 0) highest = std::max(highest, body.poles.pole.cwiseAbs().maxCoeff());
  }
  return highest / 6.0;  // a little above 1/(2 pi): every mode is below
}

/// Runs with every mode at first/4^level, each made once.
class Ladder {
 public:
  Ladder(const TrialSetup& setup, const ModalSteppingOptions& asked)
      : setup_(setup), options_(asked), first_(std::min(4.0 * asked.tolerance, 0.5)) {
    options_.highest_mode_hz = 0.0;
    options_.keep_events = false;
    runs_.resize(most_levels + reference_levels);
  }
  double tolerance(int level) const { return std::ldexp(first_, -2 * level); }
  const Trial& at(int level) {
    auto& run = runs_[static_cast<std::size_t>(level)];
    if (run) return *run;
    options_.tolerance = tolerance(level);
    run = run_trial(setup_, options_, from_);
    from_ = run->from;
    return *run;
  }

 private:
  const TrialSetup& setup_;
  ModalSteppingOptions options_;
  double first_;
  double from_ = -1.0;
  std::vector<std::optional<Trial>> runs_;
};

/// The level whose trial keeps within half of what is asked of its reference, that one's own error added; the
/// last one that can be judged where none does.
int last_level(Ladder& ladder, double asked) {
  int level = 0;
  for (;; ++level) {
    const double apart = distance(ladder.at(level), ladder.at(level + reference_levels));
    const int next = level + 1;
    if ((1.0 + reference_share) * apart <= share * asked || next == most_levels) return level;
    if (ladder.tolerance(next + reference_levels) < least_tolerance) return level;
    try {
      ladder.at(next + reference_levels);
    } catch (const Error&) {  // steps so short that they would not end: this is all that can be known
      return level;
    }
  }
}

AccuracyChoice chosen(const TrialSetup& setup, double first_cut_hz, const ModalSteppingOptions& asked,
                      bool levels) {
  Ladder ladder(setup, asked);
  AccuracyChoice choice;
  choice.tolerance = asked.tolerance;
  if (ladder.at(reference_levels).from < 0.0) return choice;  // never touched
  const int last = last_level(ladder, asked.tolerance);
  const Trial& reference = ladder.at(last + reference_levels);
  const double own_error = reference_share * distance(ladder.at(last), reference);
  const auto outcome = [&](const Trial& trial, double tolerance, double highest_mode_hz) {
    return AccuracyTrial{tolerance, highest_mode_hz, distance(trial, reference) + own_error, trial.steps,
                         trial.modes};
  };
  choice.checked_from = reference.from;
  choice.checked_until = reference.until;
  choice.reference = outcome(reference, ladder.tolerance(last + reference_levels), 0.0);
  // Contacts that do not converge with so few modes: more of them are needed.
  const auto tried_with_fewer = [&](double tolerance, double highest_mode_hz) {
    ModalSteppingOptions options = asked;
    options.keep_events = false;
    options.tolerance = tolerance;
    options.highest_mode_hz = highest_mode_hz;
    try {
      return outcome(run_trial(setup, options, choice.checked_from), tolerance, highest_mode_hz);
    } catch (const Error&) {
      return AccuracyTrial{tolerance, highest_mode_hz, std::numeric_limits<double>::infinity(), 0, 0};
    }
  };
  const double best = outcome(ladder.at(last), 0.0, 0.0).error;
  int level = 0;  // the loosest that meets the share, or errs at most 1.5 times as much as the last
  const auto enough = std::max(share * asked.tolerance, 1.5 * best);
  while (level < last && outcome(ladder.at(level), 0.0, 0.0).error > enough) ++level;
  choice.chosen = outcome(ladder.at(level), ladder.tolerance(level), 0.0);
  const double limit = asked.tolerance / (1.0 + reference_share);
  choice.known_until = within_until(setup, ladder.at(level), reference, limit);
  const double top = highest_mode(setup.bodies);
  const bool met = choice.chosen.error <= share * asked.tolerance;
  for (double cut = first_cut_hz; met && cut < top; cut *= 2.0) {
    const AccuracyTrial trial = tried_with_fewer(choice.chosen.tolerance, cut);
    if (trial.error > share * asked.tolerance) continue;
    choice.chosen = trial;
    break;
  }
  choice.tolerance = choice.chosen.tolerance;
  choice.highest_mode_hz = choice.chosen.highest_mode_hz;
  choice.estimated_error = choice.chosen.error;
  if (levels) {
    const double fewer = choice.highest_mode_hz > 0.0 ? choice.highest_mode_hz : top;
    choice.less = {tried_with_fewer(4.0 * choice.tolerance, choice.highest_mode_hz),
                   tried_with_fewer(choice.tolerance, 0.5 * fewer)};
  }
  return choice;
}

}  // namespace

double static_mode_limit(double highest_hz, double tolerance) {
  return highest_hz / std::sqrt(tolerance);
}

double first_cut_hz(double highest_hz, double tolerance, bool steady) {
  const double limit = static_mode_limit(highest_hz, tolerance);
  return steady ? std::max(highest_hz, 0.25 * limit) : limit;
}

AccuracyChoice choose_accuracy(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                               const PrescribedMotion& motion, double first_cut_hz, double duration,
                               const ModalSteppingOptions& asked, bool settle,
                               const std::function<bool(double)>& progress, bool levels, double interval) {
  try {
    return chosen({bodies, points, motion, duration, settle, progress, interval}, first_cut_hz, asked,
                  levels);
  } catch (const TrialInterrupted&) {
    AccuracyChoice none;
    none.interrupted = true;
    return none;
  }
}

}  // namespace struna::fem
