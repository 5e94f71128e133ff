#include "fem/step_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// Steps this much shorter than the longest would never end.
constexpr int deepest_level = 24;
/// Shares of the tolerance, chosen on WB-1 and the filter scene: the largest error stays below the tolerance,
/// at 1e-3 it is some 1/30 of it (docs/modal_stepping.md).
constexpr double contact_share = 1e-3;
constexpr double path_share = 1.0;
/// A contact's measure grows with h^3: doubling is safe below 1/8, with a margin.
constexpr double grow_below = 0.1;

}  // namespace

StepLoad step_load(const MotionSample& start, const MotionSample& end, double step) {
  const double du = end.displacement - start.displacement;
  const double dv = end.velocity - start.velocity;
  const double da = end.acceleration - start.acceleration;
  StepLoad load;
  load.mean[2] = dv / step;
  load.mean[1] = du / step;
  load.mean[0] = 0.5 * (start.displacement + end.displacement) - step * dv / 12.0;
  load.slope[1] = 1.2 * dv - 0.1 * step * (start.acceleration + end.acceleration);
  load.slope[0] = 1.2 * du - 0.1 * step * (start.velocity + end.velocity);
  // First moment of u'' about the middle: h (u0' + u1')/2 - (u1 - u0) = slope h^2/12. For short steps the
  // difference drowns in rounding while the plain difference of u'' has become exact.
  const double exact = 12.0 / (step * step) * (0.5 * step * (start.velocity + end.velocity) - du);
  const double rounding =
      12.0 / (step * step) * 4e-16 * (std::abs(start.displacement) + step * std::abs(start.velocity));
  load.slope[2] = rounding < 1e-3 * std::abs(da) ? exact : da;
  return load;
}

StepControl::StepControl(const ModalSteppingOptions& options) : options_(options) {
  const auto require = [](bool holds, const char* field, const char* rule, double value) {
    if (!holds) throw Error(fmt::format("ModalStepper: {} must be {}, got {}", field, rule, value));
  };
  const auto length = [&](const char* field, double value) {
    require(value >= 0.0 && std::isfinite(value), field, "zero or positive", value);
  };
  require(options.tolerance > 0.0 && options.tolerance < 1.0, "tolerance", "between 0 and 1",
          options.tolerance);
  require(options.contact_substeps >= 1, "contact_substeps", "at least 1", options.contact_substeps);
  length("step", options.step);
  length("longest_step", options.longest_step);
  length("highest_mode_hz", options.highest_mode_hz);
  length("displacement_scale", options.displacement_scale);
  if (options.longest_step > 0.0) top_ = options.longest_step;
}

void StepControl::set_lowest_pole(double angular_frequency) {
  if (options_.longest_step == 0.0 && angular_frequency > 0.0) {
    top_ = 2.0 * std::numbers::pi / angular_frequency / 16.0;
  }
}

void StepControl::set_scale(double largest_displacement, const std::vector<ContactPoint>& points) {
  if (options_.displacement_scale > 0.0) {
    scale_ = options_.displacement_scale;
    return;
  }
  scale_ = largest_displacement;
  for (const ContactPoint& point : points) scale_ = std::max(scale_, 0.1 * point.gap);
}

int StepControl::level(bool contact) const {
  if (fixed()) return contact ? 1 : 0;
  return contact ? std::max(contact_level_, free_level_) : free_level_;
}

double StepControl::step_at(int level) const {
  if (fixed()) return level == 0 ? options_.step : options_.step / options_.contact_substeps;
  return std::ldexp(top_, -level);
}

double StepControl::event_slack() const {
  return 1e-6 * step_at(level(true));
}

double StepControl::shortest_flight() const {
  return fixed() ? step_at(1) : std::ldexp(top_, -12);
}

void StepControl::begin_step() {
  load_measure_ = 0.0;
  path_measure_ = 0.0;
}

void StepControl::see_load(const StepLoad& load, const MotionSample& start, const MotionSample& end,
                           const bool (&drives)[3]) {
  if (fixed()) return;
  const double at_start[3] = {start.displacement, start.velocity, start.acceleration};
  const double at_end[3] = {end.displacement, end.velocity, end.acceleration};
  // Departure from the line is h^2 u''/12 at the ends; what it does to a mode is its square (fourth order).
  const double limit = std::sqrt(0.5 * options_.tolerance);
  for (int d = 0; d < 3; ++d) {
    if (!drives[d]) continue;
    largest_load_[d] = std::max({largest_load_[d], std::abs(at_start[d]), std::abs(at_end[d])});
    if (largest_load_[d] == 0.0) continue;
    const double miss = std::abs(at_end[d] - load.mean[d] - 0.5 * load.slope[d]);
    load_measure_ = std::max(load_measure_, miss / (limit * largest_load_[d]));
  }
}

void StepControl::see_path(const PenetrationPath& path) {
  if (fixed() || scale_ == 0.0) return;
  const double miss = std::abs(path.end - path.start - 0.5 * path.step * (path.start_rate + path.end_rate));
  const double room = -std::max(path.start, path.end);
  path_measure_ =
      std::max(path_measure_, miss / std::max(path_share * options_.tolerance * scale_, room / 8.0));
}

void StepControl::see_idle(const PenetrationPath& path, const ContactForceLaw& law) {
  if (fixed() || scale_ == 0.0) return;
  const double h = path.step;
  const double trial = std::max(spring_and_dashpot(law, path.start, path.start_rate),
                                spring_and_dashpot(law, path.end, path.end_rate));
  const double bend = std::max(std::abs(path.curvature_at(0.0)), std::abs(path.curvature_at(h)));
  const double third = std::abs(path.curvature_at(h) - path.curvature_at(0.0)) / h;
  const double hump =
      0.125 * h * h * (law.stiffness * bend + dashpot(law, std::max(path.start, path.end)) * third);
  const double least = path_share * options_.tolerance * scale_ * law.stiffness;
  path_measure_ = std::max(path_measure_, hump / std::max(least, -0.5 * trial));
}

bool StepControl::reject(bool contact, double contact_error) {
  if (fixed()) return false;
  const double contact_measure =
      contact ? contact_error / (contact_share * options_.tolerance * scale_) : 0.0;
  const double worst = std::max({load_measure_, path_measure_, contact_measure});
  const int tried = level(contact);
  if (worst > 1.0) {
    if (tried >= deepest_level) {
      throw Error(
          fmt::format("ModalStepper: the tolerance {} needs steps below {:.2g} s; lower the contact's "
                      "stiffness or damping, or "
                      "loosen the tolerance",
                      options_.tolerance, step_at(tried)));
    }
    (contact ? contact_level_ : free_level_) = tried + 1;
    if (contact && first_after_touch_) touch_level_ = tried + 1;
    return true;
  }
  const bool grow = load_measure_ < 0.2 && path_measure_ < grow_below && contact_measure < grow_below;
  if (contact && first_after_touch_) {
    touch_level_ = grow ? std::max(tried - 1, 0) : tried;
    first_after_touch_ = false;
  }
  if (grow) {
    const int longer = std::max(tried - 1, 0);
    if (contact) contact_level_ = longer;
    // In contact the free steps' level is a floor, kept for the load and the gaps that are open. What allows
    // a longer step here allows it there: a wire that lies in its bore never flies to find out.
    free_level_ = contact ? std::min(free_level_, longer) : longer;
  }
  return false;
}

bool StepControl::shorten(bool contact) {
  const int tried = level(contact);
  if (fixed() || tried >= deepest_level) return false;
  (contact ? contact_level_ : free_level_) = tried + 1;
  return true;
}

void StepControl::restart_contact() {
  contact_level_ = std::max(contact_level_, touch_level_);
  first_after_touch_ = true;
}

}  // namespace struna::fem
