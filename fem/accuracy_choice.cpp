#include "fem/accuracy_choice.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

constexpr double window = 0.02;    ///< checked beyond the first touch [s]
constexpr double interval = 2e-5;  ///< between looks [s]; static modes are most wrong just after a touch
constexpr double share = 0.5;      ///< of the tolerance that a trial may use up

/// Offsets of all points at the looks from the first touch on.
struct Trial {
  std::vector<Eigen::Vector2d> path;
  double from = 0.0, until = 0.0;  ///< [s]
  double largest = 0.0;            ///< displacement [m]
};

struct TrialSetup {
  const std::vector<ModalBody>& bodies;
  const std::vector<ContactPoint>& points;
  const PrescribedMotion& motion;
  double duration;
  bool settle;
  const std::function<bool(double)>& progress;
};

/// Thrown through the trials when the user has had enough.
struct Interrupted {};

bool touching(const ModalStepper& stepper, int points) {
  if (stepper.report().events > 0) return true;
  for (int i = 0; i < points; ++i) {
    if (stepper.penetration(i) > 0.0) return true;
  }
  return false;
}

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
    if (stop && setup.progress && !setup.progress(t)) throw Interrupted();
    stepper.advance(t);
    if (t < trial.from) continue;
    if (trial.from < 0.0) {
      if (!touching(stepper, points)) continue;
      trial.from = t;
    }
    if (t > trial.from + window) break;
    for (int i = 0; i < points; ++i) trial.path.push_back(stepper.offset(i));
    trial.until = t;
  }
  trial.largest = stepper.report().largest_displacement;
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

/// The loosest tolerance, from the one asked by quarters, that meets the share; where none does, the loosest
/// that errs at most 1.5 times as much as the best.
template <class ErrorOf>
void choose_tolerance(double asked, const ErrorOf& error_of, AccuracyChoice& choice) {
  std::vector<std::pair<double, double>> tried;  // tolerance, error
  for (double tolerance = asked; tried.size() < 4; tolerance *= 0.25) {
    tried.emplace_back(tolerance, error_of(tolerance));
    if (tried.back().second <= share * asked) break;
  }
  const auto by_error = [](const auto& a, const auto& b) { return a.second < b.second; };
  const double best = std::min_element(tried.begin(), tried.end(), by_error)->second;
  const auto enough = [&](const auto& t) { return t.second <= std::max(share * asked, 1.5 * best); };
  std::tie(choice.tolerance, choice.estimated_error) = *std::find_if(tried.begin(), tried.end(), enough);
}

AccuracyChoice chosen(const TrialSetup& setup, double highest_hz, const ModalSteppingOptions& asked) {
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
  const auto error_of = [&](double tolerance) {
    options.tolerance = tolerance;
    return distance(run_trial(setup, options, choice.checked_from), reference);
  };
  choose_tolerance(asked.tolerance, error_of, choice);
  if (choice.estimated_error > share * asked.tolerance) return choice;
  const double top = highest_mode(setup.bodies);
  for (double cut = static_mode_limit(highest_hz, asked.tolerance); cut < top; cut *= 2.0) {
    options.highest_mode_hz = cut;
    double error = 0.0;
    try {
      error = error_of(choice.tolerance);
    } catch (const Error&) {
      continue;  // contacts that do not converge with so few modes: more of them
    }
    if (error > share * asked.tolerance) continue;
    choice.highest_mode_hz = cut;
    choice.estimated_error = error;
    break;
  }
  return choice;
}

}  // namespace

double static_mode_limit(double highest_hz, double tolerance) {
  return highest_hz / std::sqrt(tolerance);
}

AccuracyChoice choose_accuracy(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                               const PrescribedMotion& motion, double highest_hz, double duration,
                               const ModalSteppingOptions& asked, bool settle,
                               const std::function<bool(double)>& progress) {
  try {
    return chosen({bodies, points, motion, duration, settle, progress}, highest_hz, asked);
  } catch (const Interrupted&) {
    AccuracyChoice none;
    none.interrupted = true;
    return none;
  }
}

}  // namespace struna::fem
