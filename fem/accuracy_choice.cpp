#include "fem/accuracy_choice.hpp"

#include <algorithm>
#include <cmath>

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
};

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
    if (trial.from >= 0.0 && t < trial.from) continue;
    stepper.advance(t);
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
  for (std::size_t i = 0; i < trial.path.size(); ++i) {
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

}  // namespace

double static_mode_limit(double highest_hz, double tolerance) {
  return highest_hz / std::sqrt(tolerance);
}

AccuracyChoice choose_accuracy(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                               const PrescribedMotion& motion, double highest_hz, double duration,
                               const ModalSteppingOptions& asked, bool settle) {
  const TrialSetup setup{bodies, points, motion, duration, settle};
  ModalSteppingOptions options = asked;
  options.highest_mode_hz = 0.0;
  options.keep_events = false;
  options.tolerance = 0.1 * asked.tolerance;
  const Trial reference = run_trial(setup, options, -1.0);
  AccuracyChoice choice;
  choice.checked_from = std::max(reference.from, 0.0);
  choice.checked_until = reference.until;
  const auto error_of = [&] { return distance(run_trial(setup, options, choice.checked_from), reference); };

  options.tolerance = asked.tolerance;
  choice.estimated_error = error_of();
  for (int k = 0; k < 3 && choice.estimated_error > share * asked.tolerance; ++k) {
    options.tolerance *= 0.25;
    choice.estimated_error = error_of();
  }
  choice.tolerance = options.tolerance;
  choice.met = choice.estimated_error <= asked.tolerance;
  if (choice.estimated_error > share * asked.tolerance) return choice;
  const double top = highest_mode(bodies);
  for (double cut = static_mode_limit(highest_hz, asked.tolerance); cut < top; cut *= 2.0) {
    options.highest_mode_hz = cut;
    double error = 0.0;
    try {
      error = error_of();
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

}  // namespace struna::fem
