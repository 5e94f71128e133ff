#include "fem/accuracy_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fem/contact_trial.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

constexpr double interval = 2e-5;  ///< between looks [s]; static modes are most wrong just after a touch
constexpr double share = 0.5;      ///< of the tolerance that a trial may use up

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
};

/// Runs to `from`, or to the first touch where `from` is negative, and records the window beyond.
Trial run_trial(const TrialSetup& setup, const ModalSteppingOptions& options, double from) {
  ModalStepper stepper(setup.bodies, setup.points, setup.motion, options);
  if (setup.settle) stepper.settle();
  const int points = static_cast<int>(setup.points.size());
  Trial trial;
  trial.from = from;
  const long last = static_cast<long>(std::floor(setup.duration / interval));
  for (long look = 0; look <= last; ++look) {
    const double t = static_cast<double>(look) * interval;
    const bool stop = look % 256 == 0;  // now and then, to be asked whether to go on
    if (t < trial.from && !stop) continue;
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

double distance(const Trial& trial, const Trial& reference) {
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(trial.path.size(), reference.path.size()); ++i) {
    worst = std::max(worst, (trial.path[i] - reference.path[i]).cwiseAbs().maxCoeff());
  }
  return reference.largest > 0.0 ? worst / reference.largest : 0.0;
}

double highest_mode(const std::vector<ModalBody>& bodies) {
  double highest = 0.0;
  for (const ModalBody& body : bodies) {
    if (body.poles.pole.size() > 0) highest = std::max(highest, body.poles.pole.cwiseAbs().maxCoeff());
  }
  return highest / 6.0;  // a little above 1/(2 pi): every mode is below
}

/// The loosest tolerance, from four times the one asked by quarters, that meets the share; where none does,
/// the loosest that errs at most 1.5 times as much as the best.
template <class Tried>
AccuracyTrial chosen_tolerance(double asked, const Tried& tried) {
  std::vector<AccuracyTrial> trials;
  for (double tolerance = 4.0 * asked; trials.size() < 5; tolerance *= 0.25) {
    trials.push_back(tried(tolerance, 0.0));
    if (trials.back().error <= share * asked) break;
  }
  const auto by_error = [](const AccuracyTrial& a, const AccuracyTrial& b) { return a.error < b.error; };
  const double best = std::min_element(trials.begin(), trials.end(), by_error)->error;
  const auto enough = [&](const AccuracyTrial& t) { return t.error <= std::max(share * asked, 1.5 * best); };
  return *std::find_if(trials.begin(), trials.end(), enough);
}

AccuracyChoice chosen(const TrialSetup& setup, double first_cut_hz, const ModalSteppingOptions& asked,
                      bool levels) {
  ModalSteppingOptions options = asked;
  options.highest_mode_hz = 0.0;
  options.keep_events = false;
  options.tolerance = 0.1 * asked.tolerance;
  const Trial reference = run_trial(setup, options, -1.0);
  AccuracyChoice choice;
  choice.tolerance = asked.tolerance;
  if (reference.from < 0.0) return choice;  // never touched
  choice.checked_from = reference.from;
  choice.checked_until = reference.until;
  choice.reference = {options.tolerance, 0.0, 0.0, reference.steps, reference.modes};
  const auto tried = [&](double tolerance, double highest_mode_hz) {
    options.tolerance = tolerance;
    options.highest_mode_hz = highest_mode_hz;
    const Trial trial = run_trial(setup, options, choice.checked_from);
    return AccuracyTrial{tolerance, highest_mode_hz, distance(trial, reference), trial.steps, trial.modes};
  };
  // Contacts that do not converge with so few modes: more of them are needed.
  const auto tried_with_fewer = [&](double tolerance, double highest_mode_hz) {
    try {
      return tried(tolerance, highest_mode_hz);
    } catch (const Error&) {
      return AccuracyTrial{tolerance, highest_mode_hz, std::numeric_limits<double>::infinity(), 0, 0};
    }
  };
  choice.chosen = chosen_tolerance(asked.tolerance, tried);
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
                               const std::function<bool(double)>& progress, bool levels) {
  try {
    return chosen({bodies, points, motion, duration, settle, progress}, first_cut_hz, asked, levels);
  } catch (const TrialInterrupted&) {
    AccuracyChoice none;
    none.interrupted = true;
    return none;
  }
}

}  // namespace struna::fem
