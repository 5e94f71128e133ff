#include "fem/modal_stepping.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "fem/error.hpp"
#include "fem/modal_stepper_state.hpp"

namespace struna::fem {

PathEvent ModalStepper::State::event_of(Instant& start, Instant& end, int point, double step,
                                        double horizon) {
  const double g0 = path_start_[point];
  const double g1 = end.penetration[point];
  const bool open = phase_[point] == ContactPhase::open;
  // In the short steps of contact, only those open points are looked at closely that could reach the wall
  // within the step at several times their pace.
  const double pace = std::max(std::abs(g1 - g0), step * std::abs(last_rate_[point]));
  if (open && !closed_.empty() && std::max(g0, g1) + 4.0 * pace < 0.0) return {never};
  // A gap that moves by no more than its own rounding says nothing of its path: its rates do, which carry
  // their own digits. Where they too move it by no more than that, as at rest, their signs are noise and no
  // events.
  const double rate0 = rate(start, point), rate1 = rate(end, point);
  const int d = system_.dimension;
  const double size = rest_offset_.segment(point * d, d).norm() + points_[point].gap + std::abs(g0);
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * size;
  const bool lost = std::abs(g1 - g0) <= rounding;
  if (lost && !open && step * std::max(std::abs(rate0), std::abs(rate1)) <= rounding) return {never};
  const PenetrationPath path{step, g0, rate0, lost ? g0 + 0.5 * step * (rate0 + rate1) : g1, rate1};
  if (open) control_.see_path(path);
  if (phase_[point] == ContactPhase::idle) control_.see_idle(path, points_[point].law);
  return first_event(path, phase_[point], points_[point].law, horizon);
}

/// The earliest event of the attempted step, and its point.
PathEvent ModalStepper::State::earliest_event(double step, int& point) {
  PathEvent best{never};
  for (int i = 0; i < point_count(); ++i) {
    const PathEvent event = event_of(now_, next_, i, step, step);
    if (event.time < best.time) {
      best = event;
      point = i;
    }
  }
  return best;
}

/// Shortens the step until it ends at its first event, to the slack. Returns its length, the attempt standing
/// in next_; or 0 when the event is due at once.
double ModalStepper::State::locate(double step, PathEvent& event, int& point, double target) {
  const double slack = control_.event_slack();
  constexpr int newton_tries = 8;  // bisection afterwards
  double lo = 0.0;
  double hi = step;
  double length = event.time;
  for (int tries = 1; length > slack; ++tries) {
    set_step(system_.poles, length, cut_.coefficients);
    attempt(cut_, std::min(time_ + length, target));
    ++report_.rejected_steps;
    PathEvent found = earliest_event(length, point);
    if (found.time < never) event = found;
    if (found.time < length - slack) {
      hi = length;
      length = tries < newton_tries ? found.time : 0.5 * (lo + hi);
      continue;
    }
    if (found.time < never || hi - length <= slack) break;
    // Short of it: the path continued says how far.
    found = event_of(now_, next_, point, length, hi);
    if (found.time <= length + slack) break;
    lo = length;
    length = tries < newton_tries && found.time < hi ? found.time : 0.5 * (lo + hi);
  }
  return length > slack ? length : 0.0;
}

void ModalStepper::State::fire(int point, ContactEvent::Kind kind) {
  const ContactForceLaw& law = points_[point].law;
  const double speed = rate(now_, point);
  ContactEvent event{time_, point, kind, speed};
  ++report_.events;
  const double stored = stored_energy(point);
  const bool lasting = time_ - last_impact_[point] < control_.shortest_flight();
  if (kind == ContactEvent::Kind::touch && law.kind == ContactLaw::hard_stop && speed > 0.0 && !lasting) {
    event.kind = ContactEvent::Kind::impact;
    last_impact_[point] = time_;
    strike(point, speed);
  } else {
    phase_[point] = phase_after(kind, law, speed);
    report_.lasting_contacts += kind == ContactEvent::Kind::touch && law.kind == ContactLaw::hard_stop;
  }
  // A spring that stops acting takes what it holds along (and brings it back when the force resumes); at
  // touch and opening that is the rounding of the event's place.
  energy_.contact_dissipated += stored - stored_energy(point);
  if (kind == ContactEvent::Kind::touch) {
    check_resolved(point);
    control_.restart_contact();
  }
  if (options_.keep_events) events_.push_back(event);
}

double ModalStepper::State::stored_energy(int point) const {
  if (!transmits(phase_[point])) return 0.0;
  return spring_energy(points_[point].law, now_.penetration[point]);
}

/// A contact so stiff that it swings within the time to which its touch is known would return a wrong speed.
void ModalStepper::State::check_resolved(int point) const {
  const double frequency = std::sqrt(points_[point].law.stiffness * mobility(point));
  if (frequency * control_.event_slack() < 1e-3) return;
  throw Error(
      fmt::format("ModalStepper: {} is too stiff to resolve ({} N/m, {:.2g} rad/s against "
                  "events located to "
                  "{:.1g} s); lower the stiffness or take the law hard_stop",
                  point_name(points_, static_cast<std::size_t>(point)), points_[point].law.stiffness,
                  frequency, control_.event_slack()));
}

/// Newton's impact: the impulse that turns the approach speed v into -r v.
void ModalStepper::State::strike(int point, double approach_speed) {
  const int d = system_.dimension;
  const double r = points_[point].law.restitution;
  const double impulse = (1.0 + r) * approach_speed / mobility(point);
  for (int s = 0; s < d; ++s) {
    const double part = -impulse * direction(now_, point, s);
    // The prescribed motion goes on through the impact and works on its impulse.
    energy_.input -= part * system_.motion[point * d + s] * now_.motion.velocity;
    for (int k = 0; k < system_.poles.size(); ++k) {
      const double p = part * system_.rows(point * d + s, system_.poles.mode[k]);
      now_.z.re[k] += system_.poles.residue_re[k] * p;
      now_.z.im[k] += system_.poles.residue_im[k] * p;
    }
  }
  energy_.contact_dissipated += 0.5 * impulse * approach_speed * (1.0 - r);
  modal_velocity(system_.poles, now_.z, now_.v);
  now_.forget_rates();
}

/// Fires every event that the accepted step ends with; next_ holds the step's start after the swap.
void ModalStepper::State::fire_due(double step) {
  for (int i = 0; i < point_count(); ++i) {
    const PathEvent event = event_of(next_, now_, i, step, step + control_.event_slack());
    if (event.time < never) fire(i, event.kind);
  }
}

bool ModalStepper::State::in_contact() const {
  return std::any_of(phase_.begin(), phase_.end(), [](ContactPhase p) { return p != ContactPhase::open; });
}

void ModalStepper::State::step_toward(double target) {
  const bool contact = in_contact();
  control_.set_scale(report_.largest_displacement, points_);
  for (;;) {
    const int level = control_.level(contact);
    double step = control_.step_at(level);
    double end_time = time_ + step;
    const StepTable* table = nullptr;
    if (step >= (target - time_) * (1.0 - 1e-9)) {
      end_time = target;
      step = target - time_;
      set_step(system_.poles, step, cut_.coefficients);
      table = &cut_;
    } else {
      table = &ladder(level);
    }
    control_.begin_step();
    try {
      attempt(*table, end_time);
    } catch (const NotConverged&) {
      if (!control_.shorten(contact)) throw;
      ++report_.rejected_steps;
      continue;
    }
    int point = -1;
    PathEvent event = frozen_ ? PathEvent{never} : earliest_event(step, point);
    if (control_.reject(contact, contact ? contact_error() : 0.0)) {
      ++report_.rejected_steps;
      continue;
    }
    if (event.time == never) {
      if (table == &cut_) set_energy(system_.poles, cut_.coefficients);
      accept(*table, end_time, contact);
      stalled_ = 0;
      return;
    }
    ++report_.rejected_steps;
    const double length = locate(step, event, point, target);
    if (length == 0.0) {
      // Due at once. Points that keep changing their phase on the spot are let go for one step.
      fire(point, event.kind);
      frozen_ = ++stalled_ > 8 + 4 * point_count();
      return;
    }
    set_energy(system_.poles, cut_.coefficients);
    accept(cut_, std::min(time_ + length, target), contact);
    stalled_ = 0;
    fire_due(length);
    return;
  }
}

void ModalStepper::State::advance(double time) {
  if (!(time >= time_) || !std::isfinite(time)) {
    throw Error(fmt::format("ModalStepper: advance must go forward from t = {} s, got {} s", time_, time));
  }
  while (time_ < time) step_toward(time);
}

ModalStepper::ModalStepper(std::vector<ModalBody> bodies, std::vector<ContactPoint> points,
                           PrescribedMotion motion, const ModalSteppingOptions& options)
    : state_(std::make_unique<State>(std::move(bodies), std::move(points), std::move(motion), options)) {}
ModalStepper::~ModalStepper() = default;
ModalStepper::ModalStepper(ModalStepper&&) noexcept = default;
ModalStepper& ModalStepper::operator=(ModalStepper&&) noexcept = default;

void ModalStepper::set_state(int body, const Eigen::VectorXd& displacement, const Eigen::VectorXd& velocity) {
  state_->set_state(body, displacement, velocity);
}
void ModalStepper::settle() {
  state_->settle();
}
void ModalStepper::advance(double time) {
  state_->advance(time);
}
double ModalStepper::time() const {
  return state_->time_;
}
Eigen::VectorXd ModalStepper::displacement(int body) const {
  return state_->displacement(body);
}
Eigen::VectorXd ModalStepper::velocity(int body) const {
  return state_->velocity(body);
}
Eigen::VectorXd ModalStepper::internal_force(int body) const {
  return state_->internal_force(body);
}
double ModalStepper::penetration(int point) const {
  return state_->now_.penetration[state_->check_point(point)];
}
double ModalStepper::force(int point) const {
  return state_->force_[state_->check_point(point)];
}
Eigen::Vector2d ModalStepper::offset(int point) const {
  return state_->offset(point);
}
const std::vector<ContactEvent>& ModalStepper::events() const {
  return state_->events_;
}
const StepReport& ModalStepper::report() const {
  return state_->report_;
}
EnergyLedger ModalStepper::energy() const {
  return state_->energy();
}

}  // namespace struna::fem
