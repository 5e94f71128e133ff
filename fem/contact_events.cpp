#include "fem/contact_events.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace struna::fem {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// The deciding function of an event, positive once the event is due, is a p(t) + b p'(t) + d of the path p.
struct Decider {
  double value_weight = 0.0;
  double rate_weight = 0.0;
  double constant = 0.0;
  ContactEvent::Kind kind = ContactEvent::Kind::touch;

  double at(const PenetrationPath& path, double t) const {
    return constant + value_weight * path.at(t) + rate_weight * path.rate_at(t);
  }
};

/// First zero in (from, to), given that the function is positive at `to`: Illinois' regula falsi. `from` when
/// it is positive there as well.
double rising_zero(const PenetrationPath& path, const Decider& decider, double from, double to) {
  double lo = from;
  double hi = to;
  double f_lo = decider.at(path, lo);
  double f_hi = decider.at(path, hi);
  if (f_lo >= 0.0) return from;
  int kept = 0;  // which end stayed last time: its value is halved when it stays again
  for (int k = 0; k < 60 && hi - lo > 1e-14 * path.step; ++k) {
    const double t = lo - f_lo * (hi - lo) / (f_hi - f_lo);
    const double f = decider.at(path, t);
    if (f == 0.0) return t;
    if (f > 0.0) {
      hi = t;
      f_hi = f;
      if (kept == -1) f_lo *= 0.5;
      kept = -1;
    } else {
      lo = t;
      f_lo = f;
      if (kept == 1) f_hi *= 0.5;
      kept = 1;
    }
  }
  return hi;
}

/// Where p' = 0 inside the step with p'' of the given sign; infinite when nowhere.
double turning_point(const PenetrationPath& path, double curvature_sign) {
  // p' is a parabola through its two ends with p'((0)), p'(h) and the mean slope.
  const double h = path.step;
  const double mean = (path.end - path.start) / h;
  const double a = 3.0 * (path.start_rate + path.end_rate - 2.0 * mean);
  const double b = 2.0 * (3.0 * mean - 2.0 * path.start_rate - path.end_rate);
  const double c = path.start_rate;
  const double discriminant = b * b - 4.0 * a * c;
  if (discriminant < 0.0) return never;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  double best = never;
  for (const double x : {a != 0.0 ? q / a : never, q != 0.0 ? c / q : never}) {
    if (x > 0.0 && x < 1.0 && path.curvature_at(x * h) * curvature_sign > 0.0) best = std::min(best, x * h);
  }
  return best;
}

double touch_time(const PenetrationPath& path, double horizon) {
  const Decider touch{1.0, 0.0, 0.0, ContactEvent::Kind::touch};
  // A point that just left moves away first: look behind the turn.
  double from = 0.0;
  if (path.start_rate < 0.0) {
    from = turning_point(path, 1.0);
    if (from == never || path.at(from) >= 0.0) return path.at(horizon) > 0.0 ? 0.0 : never;
  }
  if (path.at(horizon) > 0.0) return rising_zero(path, touch, from, horizon);
  const double top = turning_point(path, -1.0);
  if (top == never || top <= from || path.at(top) <= 0.0) return never;
  return rising_zero(path, touch, from, top);
}

double due_time(const PenetrationPath& path, const Decider& decider, double horizon) {
  if (decider.at(path, horizon) <= 0.0) return never;
  return rising_zero(path, decider, 0.0, horizon);
}

/// k g + c g' (hunt_crossley: divided by g) with a sign.
Decider force_sign(const ContactForceLaw& law, double sign, ContactEvent::Kind kind) {
  if (law.kind == ContactLaw::hunt_crossley) {
    return {0.0, sign * law.damping / law.damping_length, sign * law.stiffness, kind};
  }
  return {sign * law.stiffness, sign * law.damping, 0.0, kind};
}

}  // namespace

double PenetrationPath::at(double t) const {
  const double x = t / step;
  const double y = 1.0 - x;
  return start * (1.0 + 2.0 * x) * y * y + end * (1.0 + 2.0 * y) * x * x +
         step * x * y * (start_rate * y - end_rate * x);
}

double PenetrationPath::rate_at(double t) const {
  const double x = t / step;
  const double y = 1.0 - x;
  return 6.0 * x * y * (end - start) / step + start_rate * y * (1.0 - 3.0 * x) +
         end_rate * x * (3.0 * x - 2.0);
}

double PenetrationPath::curvature_at(double t) const {
  const double x = t / step;
  return (6.0 * (1.0 - 2.0 * x) * (end - start) / step + start_rate * (6.0 * x - 4.0) +
          end_rate * (6.0 * x - 2.0)) /
         step;
}

PathEvent first_event(const PenetrationPath& path, ContactPhase phase, const ContactForceLaw& law,
                      double horizon) {
  using Kind = ContactEvent::Kind;
  if (phase == ContactPhase::open) return {touch_time(path, horizon), Kind::touch};
  PathEvent best{never};
  const auto watch = [&](const Decider& decider) {
    const double time = due_time(path, decider, horizon);
    if (time < best.time) best = {time, decider.kind};
  };
  const bool damped = law.damping > 0.0;
  const bool releases_at_zero_gap =
      phase == ContactPhase::unloading || phase == ContactPhase::idle ||
      (phase == ContactPhase::pushing && (!damped || law.kind == ContactLaw::hunt_crossley));
  if (releases_at_zero_gap) watch({-1.0, 0.0, 0.0, Kind::open});
  if (phase == ContactPhase::loading) watch({0.0, -1.0, 0.0, Kind::approach_ends});
  if (phase == ContactPhase::unloading && damped) watch({0.0, 1.0, 0.0, Kind::approach_resumes});
  if (phase == ContactPhase::pushing && damped) watch(force_sign(law, -1.0, Kind::force_ends));
  if (phase == ContactPhase::idle) watch(force_sign(law, 1.0, Kind::force_resumes));
  return best;
}

ContactPhase phase_after(ContactEvent::Kind kind, const ContactForceLaw& law, double rate) {
  using Kind = ContactEvent::Kind;
  switch (kind) {
    case Kind::touch:
      if (law.kind != ContactLaw::approach) return ContactPhase::pushing;
      return law.damping > 0.0 && rate > 0.0 ? ContactPhase::loading : ContactPhase::unloading;
    case Kind::approach_ends:
      return ContactPhase::unloading;
    case Kind::approach_resumes:
      return ContactPhase::loading;
    case Kind::force_ends:
      return ContactPhase::idle;
    case Kind::force_resumes:
      return ContactPhase::pushing;
    case Kind::open:
    case Kind::impact:
      return ContactPhase::open;
  }
  return ContactPhase::open;
}

ContactPhase phase_of(const ContactForceLaw& law, double penetration, double rate) {
  if (penetration <= 0.0) return ContactPhase::open;
  if (law.kind == ContactLaw::approach) return phase_after(ContactEvent::Kind::touch, law, rate);
  return contact_force(law, penetration, rate) > 0.0 ? ContactPhase::pushing : ContactPhase::idle;
}

double phase_force(const ContactForceLaw& law, ContactPhase phase, double penetration, double rate) {
  if (!transmits(phase)) return 0.0;
  return spring_and_dashpot(law, penetration, phase == ContactPhase::unloading ? 0.0 : rate);
}

}  // namespace struna::fem
