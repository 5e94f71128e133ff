#include "fem/modal_stepping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "fem/contact_events.hpp"
#include "fem/contact_solver.hpp"
#include "fem/error.hpp"
#include "fem/modal_system.hpp"
#include "fem/pole_stepping.hpp"
#include "fem/step_control.hpp"

namespace struna::fem {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Coefficients of one step length, with the flexibility between all points where steps repeat.
struct StepTable {
  StepCoefficients coefficients;
  RowMatrix flexibility;  ///< rows x rows; empty: form the closed block when needed
};

/// Everything known at one instant.
struct Instant {
  PoleState z;
  Eigen::VectorXd q, v;         ///< modal
  Eigen::VectorXd offset;       ///< h, point-major
  Eigen::VectorXd penetration;  ///< g
  MotionSample motion;
  Eigen::VectorXd rate;  ///< of g, where known
  std::vector<char> rate_known;

  void forget_rates() { std::fill(rate_known.begin(), rate_known.end(), 0); }
};

bool finite(const MotionSample& m) {
  return std::isfinite(m.displacement) && std::isfinite(m.velocity) && std::isfinite(m.acceleration);
}

}  // namespace

class ModalStepper::State {
 public:
  State(std::vector<ModalBody> bodies, std::vector<ContactPoint> points, PrescribedMotion motion,
        const ModalSteppingOptions& options);

  void set_state(int body, const Eigen::VectorXd& displacement, const Eigen::VectorXd& velocity);
  void settle();
  void advance(double time);
  void prepare();

  Eigen::VectorXd per_body(int body, const Eigen::VectorXd& stepped) const;
  Eigen::VectorXd displacement(int body) const;
  Eigen::VectorXd velocity(int body) const { return per_body(body, now_.v); }
  Eigen::VectorXd internal_force(int body) const;
  Eigen::Vector2d offset(int point) const;
  EnergyLedger energy() const;
  int check_body(int body) const;
  int check_point(int point) const;

  double time_ = 0.0;
  std::vector<ContactEvent> events_;
  StepReport report_;
  std::vector<double> force_;
  Instant now_;

 private:
  int point_count() const { return static_cast<int>(points_.size()); }
  void store_state();
  void refresh(Instant& instant, double time);
  void set_geometry(Instant& instant);
  double direction(const Instant& instant, int point, int component) const;
  double rate(Instant& instant, int point) const;
  double mobility(int point) const;
  const StepTable& ladder(int level);
  void load_over(double step, const MotionSample& end);
  void closed_flexibility(const StepTable& table);
  void attempt(const StepTable& table, double end_time);
  void solve_contacts(const StepTable& table);
  void start_paths();
  PathEvent event_of(Instant& start, Instant& end, int point, double step, double horizon);
  PathEvent earliest_event(double step, int& point);
  double contact_error();
  double static_normal_flexibility(const ClosedContact& contact) const;
  void accept(const StepTable& table, double end_time, bool contact);
  double locate(double step, PathEvent& event, int& point, double target);
  void fire(int point, ContactEvent::Kind kind);
  void fire_due(double step);
  void strike(int point, double approach_speed);
  bool in_contact() const;
  void step_toward(double target);

  std::vector<ModalBody> bodies_;
  std::vector<ContactPoint> points_;
  PrescribedMotion motion_;
  ModalSteppingOptions options_;
  std::vector<Eigen::VectorXcd> poles_at_rest_;  ///< z per body, while no system is prepared
  std::vector<std::vector<char>> moving_;
  bool prepared_ = false;

  ModalSystem system_;
  StepControl control_;
  std::vector<std::unique_ptr<StepTable>> ladder_;
  StepTable cut_;
  Instant next_;
  std::vector<ContactPhase> phase_;
  Eigen::VectorXd path_start_;     ///< g at the start of the attempted step, its static deflection in place
  std::vector<double> last_rate_;  ///< secant rate of g over the last step: says which points need a look
  std::vector<double> last_impact_;
  std::vector<ClosedContact> closed_;
  ContactSolver solver_;
  RowMatrix closed_flexibility_, closed_rows_, scaled_rows_;
  Eigen::VectorXd point_force_;  ///< on the components, now: the static deflection follows it
  Eigen::VectorXd next_point_force_;
  Eigen::ArrayXd mean_, slope_, contact_load_;
  EnergyLedger energy_;
  bool drives_[3] = {};
  int stalled_ = 0;      ///< events in a row without a step between
  bool frozen_ = false;  ///< one step without event search, after a stall
};

ModalStepper::State::State(std::vector<ModalBody> bodies, std::vector<ContactPoint> points,
                           PrescribedMotion motion, const ModalSteppingOptions& options)
    : bodies_(std::move(bodies)),
      points_(std::move(points)),
      motion_(std::move(motion)),
      options_(options),
      control_(options) {
  validate(bodies_);
  std::vector<int> modes;
  for (const ModalBody& body : bodies_) {
    modes.push_back(body.poles.modes);
    poles_at_rest_.push_back(Eigen::VectorXcd::Zero(body.poles.pole.size()));
    moving_.emplace_back(body.poles.modes, 0);
  }
  fem::validate(points_, modes);
  if (!motion_) throw Error("ModalStepper: a motion is needed, got none");
  prepare();
}

int ModalStepper::State::check_body(int body) const {
  if (body < 0 || body >= static_cast<int>(bodies_.size())) {
    throw Error(fmt::format("ModalStepper: body must be one of {}, got {}", bodies_.size(), body));
  }
  return body;
}

int ModalStepper::State::check_point(int point) const {
  if (point < 0 || point >= point_count()) {
    throw Error(fmt::format("ModalStepper: contact point must be one of {}, got {}", point_count(), point));
  }
  return point;
}

// ---- states
// ------------------------------------------------------------------------------------------------------

void ModalStepper::State::store_state() {
  for (std::size_t k = 0; k < system_.pole_origin.size(); ++k) {
    const ModalOrigin origin = system_.pole_origin[k];
    const auto at = static_cast<Eigen::Index>(k);
    poles_at_rest_[origin.body][origin.index] = {now_.z.re[at], now_.z.im[at]};
  }
}

void ModalStepper::State::prepare() {
  system_ = modal_system(bodies_, points_, moving_, options_.highest_mode_hz);
  const int n = system_.poles.size();
  const int rows = static_cast<int>(system_.rest.size());
  for (Instant* instant : {&now_, &next_}) {
    instant->z.re.setZero(n);
    instant->z.im.setZero(n);
    instant->q.setZero(system_.poles.modes);
    instant->v.setZero(system_.poles.modes);
    instant->offset.setZero(rows);
    instant->penetration.setZero(point_count());
    instant->rate.setZero(point_count());
    instant->rate_known.assign(point_count(), 0);
  }
  for (int k = 0; k < n; ++k) {
    const ModalOrigin origin = system_.pole_origin[k];
    now_.z.re[k] = poles_at_rest_[origin.body][origin.index].real();
    now_.z.im[k] = poles_at_rest_[origin.body][origin.index].imag();
  }
  mean_.setZero(system_.poles.modes);
  slope_.setZero(system_.poles.modes);
  contact_load_.setZero(system_.poles.modes);
  point_force_.setZero(rows);
  next_point_force_.setZero(rows);
  phase_.assign(point_count(), ContactPhase::open);
  force_.assign(point_count(), 0.0);
  path_start_.setZero(point_count());
  last_rate_.assign(point_count(), 0.0);
  last_impact_.assign(point_count(), -never);
  closed_.reserve(point_count());
  solver_.reserve(point_count(), system_.dimension);
  ladder_.clear();
  for (int d = 0; d < 3; ++d) drives_[d] = (system_.load.col(d) != 0.0).any();
  report_.modes = system_.poles.modes;
  report_.static_modes = static_cast<int>(system_.static_origin.size());
  report_.idle_modes = system_.idle_modes;
  report_.planar = system_.dimension == 1;
  control_.set_lowest_pole(n > 0 ? (system_.poles.re.square() + system_.poles.im.square()).sqrt().minCoeff()
                                 : 0.0);
  refresh(now_, time_);
  for (int i = 0; i < point_count(); ++i) {
    phase_[i] = phase_of(points_[i].law, now_.penetration[i], rate(now_, i));
    force_[i] = phase_force(points_[i].law, phase_[i], now_.penetration[i], rate(now_, i));
  }
  energy_ = EnergyLedger{};
  const EnergyLedger start = energy();
  energy_.initial = start.kinetic + start.strain + start.contact_stored;
  prepared_ = true;
}

void ModalStepper::State::refresh(Instant& instant, double time) {
  instant.motion = motion_(time);
  if (!finite(instant.motion))
    throw Error(fmt::format("ModalStepper: the motion at t = {} s is not finite", time));
  modal_displacement(system_.poles, instant.z, instant.q);
  modal_velocity(system_.poles, instant.z, instant.v);
  instant.offset.noalias() = system_.rows * instant.q;
  instant.offset += system_.rest + system_.motion * instant.motion.displacement;
  if (system_.static_flexibility.size()) instant.offset += system_.static_flexibility * point_force_;
  set_geometry(instant);
}

void ModalStepper::State::set_geometry(Instant& instant) {
  instant.forget_rates();
  const int d = system_.dimension;
  for (int i = 0; i < point_count(); ++i) {
    instant.penetration[i] = contact_distance(points_[i].shape, &instant.offset[i * d], d) - points_[i].gap;
  }
}

void ModalStepper::State::set_state(int body, const Eigen::VectorXd& displacement,
                                    const Eigen::VectorXd& velocity) {
  const PoleSystem& poles = bodies_[check_body(body)].poles;
  if (displacement.size() != poles.modes || velocity.size() != poles.modes) {
    throw Error(fmt::format("set_state: body {} has {} modes, got {} displacements and {} velocities", body,
                            poles.modes, displacement.size(), velocity.size()));
  }
  if (!displacement.allFinite() || !velocity.allFinite()) {
    throw Error(fmt::format("set_state: displacements and velocities of body {} must be finite", body));
  }
  store_state();
  // At rest under the constant load k q the poles are -r k q/mu; an impulse v adds r v.
  Eigen::VectorXd compliance = Eigen::VectorXd::Zero(poles.modes);
  for (Eigen::Index k = 0; k < poles.pole.size(); ++k) {
    compliance[poles.mode[k]] -= (poles.residue[k] / poles.pole[k]).real();
  }
  for (Eigen::Index k = 0; k < poles.pole.size(); ++k) {
    const int m = poles.mode[k];
    poles_at_rest_[body][k] =
        poles.residue[k] * (velocity[m] - displacement[m] / compliance[m] / poles.pole[k]);
  }
  for (int m = 0; m < poles.modes; ++m) {
    if (displacement[m] != 0.0 || velocity[m] != 0.0) moving_[body][m] = 1;
  }
  prepare();
}

void ModalStepper::State::settle() {
  const MotionSample motion = motion_(time_);
  if (!finite(motion)) throw Error(fmt::format("ModalStepper: the motion at t = {} s is not finite", time_));
  const Eigen::ArrayXd load = system_.constant_load + system_.load.col(0) * motion.displacement;
  const Eigen::ArrayXd compliance = 1.0 / system_.relaxed_stiffness;
  Eigen::VectorXd offset =
      system_.rest + system_.motion * motion.displacement + system_.rows * (compliance * load).matrix();
  RowMatrix w = system_.rows * compliance.matrix().asDiagonal() * system_.rows.transpose();
  if (system_.static_flexibility.size()) w += system_.static_flexibility;
  const int d = system_.dimension;
  closed_.clear();
  for (int i = 0; i < point_count(); ++i) {
    ClosedContact c;
    c.point = i;
    c.law = &points_[i].law;
    c.shape = points_[i].shape;
    c.gap = points_[i].gap;
    std::copy_n(&offset[i * d], d, c.end_offset);
    closed_.push_back(c);
  }
  if (!solver_.settle(closed_, d, w)) {
    throw Error(
        "settle: the static equilibrium with contact was not found; start from rest without gravity, or "
        "soften the contact");
  }
  point_force_.setZero();
  for (const ClosedContact& c : closed_) {
    for (int s = 0; s < d; ++s) point_force_[c.point * d + s] = -c.direction[s] * c.force;
  }
  const Eigen::ArrayXd total = load + (system_.rows.transpose() * point_force_).array();
  for (int k = 0; k < system_.poles.size(); ++k) {
    const std::complex<double> mu(system_.poles.re[k], system_.poles.im[k]);
    const std::complex<double> residue(system_.poles.residue_re[k], system_.poles.residue_im[k]);
    const std::complex<double> z = -residue / mu * total[system_.poles.mode[k]];
    now_.z.re[k] = z.real();
    now_.z.im[k] = z.imag();
  }
  refresh(now_, time_);
  for (const ClosedContact& c : closed_) {
    // At rest the dashpot is silent, whichever law.
    phase_[c.point] = phase_of(c.law[0], now_.penetration[c.point], 0.0);
    force_[c.point] = c.force;
  }
  energy_ = EnergyLedger{};
  const EnergyLedger start = energy();
  energy_.initial = start.kinetic + start.strain + start.contact_stored;
}

// ---- geometry and flexibility
// ------------------------------------------------------------------------------------

double ModalStepper::State::direction(const Instant& instant, int point, int component) const {
  if (points_[point].shape == StopShape::wall) return component == 0 ? 1.0 : 0.0;
  const int d = system_.dimension;
  const double size = contact_distance(StopShape::bore, &instant.offset[point * d], d);
  return size > 0.0 ? instant.offset[point * d + component] / size : 0.0;
}

double ModalStepper::State::rate(Instant& instant, int point) const {
  if (instant.rate_known[point]) return instant.rate[point];
  const int d = system_.dimension;
  double sum = 0.0;
  for (int s = 0; s < d; ++s) {
    const double n = direction(instant, point, s);
    if (n == 0.0) continue;
    const int row = point * d + s;
    sum += n * (system_.rows.row(row).dot(instant.v) + system_.motion[row] * instant.motion.velocity);
  }
  instant.rate[point] = sum;
  instant.rate_known[point] = 1;
  return sum;
}

/// Velocity that a unit impulse along the present normal gives the point [1/kg].
double ModalStepper::State::mobility(int point) const {
  const int d = system_.dimension;
  Eigen::VectorXd row = Eigen::VectorXd::Zero(system_.poles.modes);
  for (int s = 0; s < d; ++s) row += direction(now_, point, s) * system_.rows.row(point * d + s).transpose();
  return row.squaredNorm();
}

const StepTable& ModalStepper::State::ladder(int level) {
  if (static_cast<int>(ladder_.size()) <= level) ladder_.resize(level + 1);
  if (!ladder_[level]) {
    auto table = std::make_unique<StepTable>();
    set_step(system_.poles, control_.step_at(level), table->coefficients);
    set_energy(system_.poles, table->coefficients);
    const auto& flexibility = table->coefficients.flexibility;
    table->flexibility = system_.rows * flexibility.matrix().asDiagonal() * system_.rows.transpose();
    if (system_.static_flexibility.size()) table->flexibility += system_.static_flexibility;
    ladder_[level] = std::move(table);
  }
  return *ladder_[level];
}

void ModalStepper::State::closed_flexibility(const StepTable& table) {
  const int d = system_.dimension;
  const int n = static_cast<int>(closed_.size());
  closed_flexibility_.resize(n * d, n * d);
  if (table.flexibility.size()) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        closed_flexibility_.block(i * d, j * d, d, d) =
            table.flexibility.block(closed_[i].point * d, closed_[j].point * d, d, d);
      }
    }
    return;
  }
  closed_rows_.resize(n * d, system_.poles.modes);
  for (int i = 0; i < n; ++i)
    closed_rows_.middleRows(i * d, d) = system_.rows.middleRows(closed_[i].point * d, d);
  scaled_rows_ = closed_rows_ * table.coefficients.flexibility.matrix().asDiagonal();
  closed_flexibility_.noalias() = scaled_rows_ * closed_rows_.transpose();
  if (!system_.static_flexibility.size()) return;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      closed_flexibility_.block(i * d, j * d, d, d) +=
          system_.static_flexibility.block(closed_[i].point * d, closed_[j].point * d, d, d);
    }
  }
}

// ---- one step
// ----------------------------------------------------------------------------------------------------

/// Mean and slope of the modal loads over a step: exact mean and first moment of u'' from u' and u at the
/// ends; u' and u by the cubic of Hermite.
void ModalStepper::State::load_over(double step, const MotionSample& end) {
  const StepLoad load = step_load(now_.motion, end, step);
  mean_ = system_.constant_load;
  slope_.setZero();
  for (int d = 0; d < 3; ++d) {
    if (!drives_[d]) continue;
    mean_ += system_.load.col(d) * load.mean[d];
    slope_ += system_.load.col(d) * load.slope[d];
  }
  control_.see_load(load, now_.motion, end, drives_);
}

void ModalStepper::State::attempt(const StepTable& table, double end_time) {
  const StepCoefficients& c = table.coefficients;
  next_.motion = motion_(end_time);
  if (!finite(next_.motion)) {
    throw Error(fmt::format("ModalStepper: the motion at t = {} s is not finite", end_time));
  }
  load_over(c.step, next_.motion);
  propagate(system_.poles, c, mean_, slope_, now_.z, next_.z);
  modal_displacement(system_.poles, next_.z, next_.q);
  next_.offset.noalias() = system_.rows * next_.q;
  next_.offset += system_.rest + system_.motion * next_.motion.displacement;
  closed_.clear();
  for (int i = 0; i < point_count(); ++i) {
    if (!transmits(phase_[i])) continue;
    const int d = system_.dimension;
    ClosedContact contact;
    contact.point = i;
    contact.law = &points_[i].law;
    contact.phase = phase_[i];
    contact.shape = points_[i].shape;
    contact.gap = points_[i].gap;
    std::copy_n(&now_.offset[i * d], d, contact.start_offset);
    std::copy_n(&next_.offset[i * d], d, contact.end_offset);
    contact.start_penetration = now_.penetration[i];
    contact.force = force_[i];
    closed_.push_back(contact);
  }
  next_point_force_.setZero();
  if (!closed_.empty()) solve_contacts(table);
  set_geometry(next_);
  start_paths();
  modal_velocity(system_.poles, next_.z, next_.v);
}

/// Static modes follow the force of the step at once, so the path of a gap starts after that jump.
void ModalStepper::State::start_paths() {
  path_start_ = now_.penetration;
  if (!system_.static_flexibility.size()) return;
  const int d = system_.dimension;
  const Eigen::VectorXd offset =
      now_.offset + system_.static_flexibility * (next_point_force_ - point_force_);
  for (int i = 0; i < point_count(); ++i) {
    path_start_[i] = contact_distance(points_[i].shape, &offset[i * d], d) - points_[i].gap;
  }
}

void ModalStepper::State::solve_contacts(const StepTable& table) {
  const StepCoefficients& c = table.coefficients;
  const int d = system_.dimension;
  closed_flexibility(table);
  if (!solver_.solve(closed_, d, closed_flexibility_, c.step)) {
    throw Error(fmt::format(
        "ModalStepper: contact forces at t = {} s did not converge (step {} s, {} closed contacts); "
        "lower the contact stiffness or the step",
        time_, c.step, closed_.size()));
  }
  contact_load_.setZero();
  for (const ClosedContact& contact : closed_) {
    for (int s = 0; s < d; ++s) {
      const int row = contact.point * d + s;
      next_point_force_[row] = -contact.direction[s] * contact.force;
      contact_load_.matrix() += next_point_force_[row] * system_.rows.row(row).transpose();
    }
  }
  add_constant_load(system_.poles, c, contact_load_, next_.z);
  next_.q.array() += c.flexibility * contact_load_;
  if (table.flexibility.size()) {
    for (const ClosedContact& contact : closed_) {
      for (int s = 0; s < d; ++s) {
        const int row = contact.point * d + s;
        next_.offset += next_point_force_[row] * table.flexibility.row(row).transpose();
      }
    }
    return;
  }
  next_.offset.noalias() = system_.rows * next_.q;
  next_.offset += system_.rest + system_.motion * next_.motion.displacement;
  if (system_.static_flexibility.size()) next_.offset += system_.static_flexibility * next_point_force_;
}

double ModalStepper::State::static_normal_flexibility(const ClosedContact& c) const {
  if (!system_.static_flexibility.size()) return 0.0;
  const int d = system_.dimension;
  double sum = 0.0;
  for (int r = 0; r < d; ++r) {
    for (int s = 0; s < d; ++s) {
      sum += c.direction[r] * system_.static_flexibility(c.point * d + r, c.point * d + s) * c.direction[s];
    }
  }
  return sum;
}

/// Estimated displacement error of the step: constant instead of linear contact forces, W dF/6 [m] (a free
/// mass under a force that changes by dF over the step is off by h^2 dF/(12 m), W = h^2/(2 m)).
double ModalStepper::State::contact_error() {
  double worst = 0.0;
  for (const ClosedContact& c : closed_) {
    const double start = phase_force(*c.law, c.phase, c.start_penetration, rate(now_, c.point));
    const double end = phase_force(*c.law, c.phase, c.end_penetration, rate(next_, c.point));
    // Static modes take their part of a change at once, whatever the step.
    const double flexibility = c.normal_flexibility - static_normal_flexibility(c);
    worst = std::max(worst, flexibility * std::abs(end - start) / 6.0);
  }
  return worst;
}

void ModalStepper::State::accept(const StepTable& table, double end_time, bool contact) {
  const StepCoefficients& c = table.coefficients;
  if (closed_.empty()) contact_load_.setZero();
  const StepEnergy work = step_energy(system_.poles, c, mean_, slope_, contact_load_, now_.z, next_.z);
  energy_.input += work.load_work;
  energy_.body_dissipated += work.dissipated + work.internal_work;
  for (const ClosedContact& closed : closed_) {
    energy_.contact_dissipated += contact_heat(closed, c.step);
    for (int s = 0; s < system_.dimension; ++s) {
      // The prescribed motion works on the contact forces as well.
      const int row = closed.point * system_.dimension + s;
      energy_.input += closed.direction[s] * closed.force * system_.motion[row] *
                       (next_.motion.displacement - now_.motion.displacement);
    }
  }
  if (system_.static_flexibility.size()) {
    // Static modes under a jump of force are dampers without memory: half of the work of the jump is lost.
    const Eigen::VectorXd jump = next_point_force_ - point_force_;
    energy_.body_dissipated += 0.5 * jump.dot(system_.static_flexibility * jump);
  }
  for (int i = 0; i < point_count(); ++i) {
    last_rate_[i] = (next_.penetration[i] - now_.penetration[i]) / c.step;
    force_[i] = 0.0;
  }
  for (const ClosedContact& closed : closed_) force_[closed.point] = closed.force;
  std::swap(now_, next_);
  std::swap(point_force_, next_point_force_);
  time_ = end_time;
  frozen_ = false;
  (contact ? report_.contact_steps : report_.free_steps) += 1;
  report_.shortest_step = report_.shortest_step == 0.0 ? c.step : std::min(report_.shortest_step, c.step);
  report_.longest_step = std::max(report_.longest_step, c.step);
  if (point_count() > 0) {
    report_.largest_penetration = std::max(report_.largest_penetration, now_.penetration.maxCoeff());
    const double displacement = (now_.offset - system_.rest).cwiseAbs().maxCoeff();
    report_.largest_displacement = std::max(report_.largest_displacement, displacement);
    if (!std::isfinite(displacement)) {
      throw Error(fmt::format("ModalStepper: the solution is not finite at t = {} s", time_));
    }
  }
}

// ---- events
// ------------------------------------------------------------------------------------------------------

PathEvent ModalStepper::State::event_of(Instant& start, Instant& end, int point, double step,
                                        double horizon) {
  const double g0 = path_start_[point];
  const double g1 = end.penetration[point];
  const bool open = phase_[point] == ContactPhase::open;
  // In the short steps of contact, only those open points are looked at closely that could reach the wall
  // within the step at several times their pace.
  const double pace = std::max(std::abs(g1 - g0), step * std::abs(last_rate_[point]));
  if (open && !closed_.empty() && std::max(g0, g1) + 4.0 * pace < 0.0) return {never};
  const PenetrationPath path{step, g0, rate(start, point), g1, rate(end, point)};
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
  const double stored = contact_energy(law, now_.penetration[point]);
  if (kind == ContactEvent::Kind::force_ends) energy_.contact_dissipated += stored;
  if (kind == ContactEvent::Kind::force_resumes) energy_.contact_dissipated -= stored;
  const bool lasting = time_ - last_impact_[point] < control_.shortest_flight();
  if (kind == ContactEvent::Kind::touch && law.kind == ContactLaw::hard_stop && speed > 0.0 && !lasting) {
    event.kind = ContactEvent::Kind::impact;
    last_impact_[point] = time_;
    strike(point, speed);
  } else {
    phase_[point] = phase_after(kind, law, speed);
  }
  if (kind == ContactEvent::Kind::touch) control_.restart_contact();
  if (options_.keep_events) events_.push_back(event);
}

/// Newton's impact: the impulse that turns the approach speed v into -r v.
void ModalStepper::State::strike(int point, double approach_speed) {
  const int d = system_.dimension;
  const double r = points_[point].law.restitution;
  const double impulse = (1.0 + r) * approach_speed / mobility(point);
  for (int s = 0; s < d; ++s) {
    const double part = -impulse * direction(now_, point, s);
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

// ---- the loop
// ----------------------------------------------------------------------------------------------------

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
    attempt(*table, end_time);
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

// ---- what can be read
// --------------------------------------------------------------------------------------------

Eigen::VectorXd ModalStepper::State::per_body(int body, const Eigen::VectorXd& stepped) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(bodies_[check_body(body)].poles.modes);
  for (std::size_t m = 0; m < system_.mode_origin.size(); ++m) {
    const ModalOrigin origin = system_.mode_origin[m];
    if (origin.body == body) out[origin.index] = stepped[static_cast<Eigen::Index>(m)];
  }
  return out;
}

Eigen::VectorXd ModalStepper::State::displacement(int body) const {
  Eigen::VectorXd out = per_body(body, now_.q);
  for (std::size_t m = 0; m < system_.static_origin.size(); ++m) {
    const ModalOrigin origin = system_.static_origin[m];
    const auto at = static_cast<Eigen::Index>(m);
    if (origin.body == body) {
      out[origin.index] = system_.static_compliance[at] * system_.static_rows.col(at).dot(point_force_);
    }
  }
  return out;
}

Eigen::VectorXd ModalStepper::State::internal_force(int body) const {
  Eigen::VectorXd force;
  modal_internal_force(system_.poles, now_.z, force);
  Eigen::VectorXd out = per_body(body, force);
  for (std::size_t m = 0; m < system_.static_origin.size(); ++m) {
    const ModalOrigin origin = system_.static_origin[m];
    if (origin.body == body) {
      out[origin.index] = system_.static_rows.col(static_cast<Eigen::Index>(m)).dot(point_force_);
    }
  }
  return out;
}

Eigen::Vector2d ModalStepper::State::offset(int point) const {
  if (system_.dimension == 2) return now_.offset.segment<2>(2 * check_point(point));
  return now_.offset[check_point(point)] * system_.line[point];
}

EnergyLedger ModalStepper::State::energy() const {
  EnergyLedger energy = energy_;
  energy.kinetic = 0.5 * now_.v.squaredNorm();
  energy.strain = 0.5 * (system_.relaxed_stiffness * now_.q.array().square()).sum();
  // Of viscoelastic modes the internal work is booked as dissipated: what the springs hold goes back here.
  for (int m = system_.poles.single; m < system_.poles.modes; ++m) {
    if (!system_.viscoelastic[m]) continue;
    const double strain = 0.5 * system_.relaxed_stiffness[m] * now_.q[m] * now_.q[m];
    energy.body_dissipated -= strain;
  }
  if (system_.static_flexibility.size()) {
    energy.strain += 0.5 * point_force_.dot(system_.static_flexibility * point_force_);
  }
  energy.contact_stored = 0.0;
  for (int i = 0; i < point_count(); ++i) {
    if (transmits(phase_[i])) {
      energy.contact_stored += 0.5 * points_[i].law.stiffness * now_.penetration[i] * now_.penetration[i];
    }
  }
  return energy;
}

// ---- the public face
// ---------------------------------------------------------------------------------------------

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
