#include "fem/step_check.hpp"

#include <algorithm>
#include <cmath>

#include "fem/contact_trial.hpp"

namespace struna::fem {
namespace {

constexpr double least_interval = 2e-5;  ///< between looks, of whole steps [s]
constexpr double refinement = 4.0;       ///< of the step
/// Distance from a quarter of the step to error. Of first order it would be 4/3; over maps of steps and
/// contacts (docs/limits.md) it is that of second order.
constexpr double of_second_order = 16.0 / 15.0;

void start(NewmarkStepper& stepper, bool settle) {
  settle ? stepper.settle() : stepper.follow_base();
}
void start(ModalStepper& stepper, bool settle) {
  if (settle) stepper.settle();
}

template <class Stepper>
std::vector<Eigen::Vector2d> offsets(const Stepper& stepper, std::size_t points) {
  std::vector<Eigen::Vector2d> all;
  for (std::size_t i = 0; i < points; ++i) all.push_back(stepper.offset(static_cast<int>(i)));
  return all;
}

template <class Stepper, class Bodies, class Options>
StepCheck checked(const Bodies& bodies, const std::vector<ContactPoint>& points,
                  const PrescribedMotion& motion, double duration, const Options& options, bool settle,
                  const std::function<bool(double)>& progress, double looks) {
  const double interval = looks > 0.0 ? looks : options.step * std::ceil(least_interval / options.step);
  const auto asked_on = [&](long look, double t) {
    if (look % 256 == 0 && progress && !progress(t)) throw TrialInterrupted();
  };
  Stepper coarse(bodies, points, motion, options);
  start(coarse, settle);
  const auto time_of = [&](long look) { return static_cast<double>(look) * interval; };
  long first = -1;
  std::vector<std::vector<Eigen::Vector2d>> path;
  for (long look = 0; time_of(look) <= duration; ++look) {
    asked_on(look, time_of(look));
    coarse.advance(time_of(look));
    if (first < 0 && touching(coarse, points.size())) first = look;
    if (first >= 0) path.push_back(offsets(coarse, points.size()));
    if (first >= 0 && time_of(look - first) >= checked_beyond_touch) break;
  }
  StepCheck check;
  if (first < 0) return check;
  Options finer = options;
  finer.step = options.step / refinement;
  Stepper fine(bodies, points, motion, finer);
  start(fine, settle);
  const long last = first + static_cast<long>(path.size()) - 1;
  double worst = 0.0;
  for (long look = 0; look <= last; ++look) {
    asked_on(look, time_of(look));
    fine.advance(time_of(look));
    if (look < first) continue;
    const auto now = offsets(fine, points.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      const auto& then = path[static_cast<std::size_t>(look - first)][i];
      worst = std::max(worst, (now[i] - then).cwiseAbs().maxCoeff());
    }
  }
  const double largest = fine.report().largest_displacement;
  check.estimated_error = largest > 0.0 ? of_second_order * worst / largest : 0.0;
  check.checked_until = time_of(last);
  return check;
}

template <class Stepper, class... Arguments>
StepCheck checked_unless_stopped(const Arguments&... arguments) {
  try {
    return checked<Stepper>(arguments...);
  } catch (const TrialInterrupted&) {
    StepCheck none;
    none.interrupted = true;
    return none;
  }
}

}  // namespace

StepCheck check_step(const std::vector<NodalBody>& bodies, const std::vector<ContactPoint>& points,
                     const PrescribedMotion& motion, double duration, const NewmarkOptions& options,
                     bool settle, const std::function<bool(double)>& progress, double interval) {
  return checked_unless_stopped<NewmarkStepper>(bodies, points, motion, duration, options, settle, progress,
                                                interval);
}

StepCheck check_step(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                     const PrescribedMotion& motion, double duration, const ModalSteppingOptions& options,
                     bool settle, const std::function<bool(double)>& progress, double interval) {
  return checked_unless_stopped<ModalStepper>(bodies, points, motion, duration, options, settle, progress,
                                              interval);
}

}  // namespace struna::fem
