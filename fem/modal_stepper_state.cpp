#include "fem/modal_stepper_state.hpp"

#include <fmt/format.h>

#include <complex>
#include <numbers>

#include "fem/contact_rest.hpp"
#include "fem/error.hpp"

namespace struna::fem {

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
    stored_poles_.push_back(Eigen::VectorXcd::Zero(body.poles.pole.size()));
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

void ModalStepper::State::store_state() {
  for (std::size_t k = 0; k < system_.pole_origin.size(); ++k) {
    const ModalOrigin origin = system_.pole_origin[k];
    const auto at = static_cast<Eigen::Index>(k);
    std::complex<double> z(now_.z.re[at], now_.z.im[at]);
    const auto mode = static_cast<Eigen::Index>(system_.poles.mode[k]);
    // What the rest held, held by relaxed springs from now on.
    const double held = system_.relaxed_stiffness[mode] * rest_q_[mode];
    const PoleSystem& poles = bodies_[origin.body].poles;
    if (held != 0.0) z -= poles.residue[origin.index] / poles.pole[origin.index] * held;
    stored_poles_[origin.body][origin.index] = z;
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
    now_.z.re[k] = stored_poles_[origin.body][origin.index].real();
    now_.z.im[k] = stored_poles_[origin.body][origin.index].imag();
  }
  mean_.setZero(system_.poles.modes);
  slope_.setZero(system_.poles.modes);
  rest_q_.setZero(system_.poles.modes);
  rest_load_.setZero(system_.poles.modes);
  rest_offset_ = system_.rest;
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
  report_.planar = !points_.empty() && system_.dimension == 1;
  double lowest_hz = never;  // of what oscillates
  for (const double f : system_.frequency_hz) {
    if (f > 0.0) lowest_hz = std::min(lowest_hz, f);
  }
  control_.set_lowest_pole(lowest_hz < never ? 2.0 * std::numbers::pi * lowest_hz : 0.0);
  refresh(now_, time_);
  deflect_static_modes();
  for (int i = 0; i < point_count(); ++i) {
    phase_[i] = phase_of(points_[i].law, now_.penetration[i], rate(now_, i));
    force_[i] = phase_force(points_[i].law, phase_[i], now_.penetration[i], rate(now_, i));
  }
  start_ledger();
}

void ModalStepper::State::start_ledger() {
  energy_ = EnergyLedger{};
  const EnergyLedger start = energy();
  energy_.initial = start.kinetic + start.strain + start.contact_stored;
}

/// A state with closed contacts: static modes, which have no mass, stand in equilibrium with them at once.
void ModalStepper::State::deflect_static_modes() {
  if (!system_.static_flexibility.size() || point_count() == 0 || now_.penetration.maxCoeff() <= 0.0) return;
  balance(now_.offset, system_.static_flexibility);
  refresh(now_, time_);
}

/// Point forces in static equilibrium: `offset` without them, `w` the flexibility between the points.
void ModalStepper::State::balance(const Eigen::VectorXd& offset, const RowMatrix& w) {
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
  if (!rest_in_contact(closed_, d, w)) {
    throw Error(
        "ModalStepper: the static equilibrium with contact was not found: the offsets are not finite, or the "
        "contact's stiffness leaves only rounding of its forces");
  }
  point_force_.setZero();
  for (const ClosedContact& c : closed_) {
    for (int s = 0; s < d; ++s) point_force_[c.point * d + s] = -c.direction[s] * c.force;
  }
}

void ModalStepper::State::refresh(Instant& instant, double time) {
  instant.motion = motion_(time);
  if (!finite(instant.motion))
    throw Error(fmt::format("ModalStepper: the motion at t = {} s is not finite", time));
  modal_displacement(system_.poles, instant.z, instant.q);
  modal_velocity(system_.poles, instant.z, instant.v);
  instant.offset.noalias() = system_.rows * instant.q;
  instant.offset += rest_offset_ + system_.motion * instant.motion.displacement;
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
  // At rest under the constant load k q the poles are -r k q/mu; an impulse v adds r v. Rigid modes: (q, q').
  Eigen::VectorXd compliance = Eigen::VectorXd::Zero(poles.modes);
  const auto rigid = [&](Eigen::Index k) {
    const bool first = k == 0 || poles.mode[k - 1] != poles.mode[k];
    const bool last = k + 1 == poles.pole.size() || poles.mode[k + 1] != poles.mode[k];
    return first && last && is_rigid_pole(poles, static_cast<int>(k), static_cast<int>(k) + 1);
  };
  for (Eigen::Index k = 0; k < poles.pole.size(); ++k) {
    if (!rigid(k)) compliance[poles.mode[k]] -= (poles.residue[k] / poles.pole[k]).real();
  }
  for (Eigen::Index k = 0; k < poles.pole.size(); ++k) {
    const int m = poles.mode[k];
    if (rigid(k)) {
      stored_poles_[body][k] = {displacement[m], velocity[m]};
      continue;
    }
    stored_poles_[body][k] =
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
  const Eigen::ArrayXd compliance = (system_.rest_stiffness > 0.0).select(1.0 / system_.rest_stiffness, 0.0);
  Eigen::VectorXd offset =
      system_.rest + system_.motion * motion.displacement + system_.rows * (compliance * load).matrix();
  RowMatrix w = system_.rows * compliance.matrix().asDiagonal() * system_.rows.transpose();
  if (system_.static_flexibility.size()) w += system_.static_flexibility;
  balance(offset, w);
  const Eigen::ArrayXd total = load + (system_.rows.transpose() * point_force_).array();
  refuse_falling(total);
  now_.z.re.setZero();
  now_.z.im.setZero();
  rest_q_ = compliance * total;
  rest_load_ = total;
  rest_offset_ = system_.rest + system_.rows * rest_q_;
  refresh(now_, time_);
  for (const ClosedContact& c : closed_) {
    // At rest the dashpot is silent, whichever law.
    phase_[c.point] = phase_of(c.law[0], now_.penetration[c.point], 0.0);
    force_[c.point] = c.force;
  }
  start_ledger();
}

/// A rest whose loads push a rigid mode is none.
void ModalStepper::State::refuse_falling(const Eigen::ArrayXd& load) const {
  const double largest = load.size() ? load.abs().maxCoeff() : 0.0;
  constexpr double rounding = 1e-8;  // of the balance of contact forces against each other
  for (Eigen::Index m = 0; m < load.size(); ++m) {
    if (system_.rest_stiffness[m] > 0.0 || std::abs(load[m]) <= rounding * largest) continue;
    throw Error(
        fmt::format("ModalStepper: the static rest was asked for, but its loads push body {} along a motion "
                    "that no support holds: it would fall or swing; clamp it, or take the load away",
                    system_.mode_origin[static_cast<std::size_t>(m)].body));
  }
}

Eigen::VectorXd ModalStepper::State::per_body(int body, const Eigen::VectorXd& stepped) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(bodies_[check_body(body)].poles.modes);
  for (std::size_t m = 0; m < system_.mode_origin.size(); ++m) {
    const ModalOrigin origin = system_.mode_origin[m];
    if (origin.body == body) out[origin.index] = stepped[static_cast<Eigen::Index>(m)];
  }
  return out;
}

/// Load that a static mode follows: prescribed, constant, contact.
double ModalStepper::State::static_force(Eigen::Index mode) const {
  const MotionSample& u = now_.motion;
  const double load = system_.static_load(mode, 0) * u.displacement +
                      system_.static_load(mode, 1) * u.velocity +
                      system_.static_load(mode, 2) * u.acceleration + system_.static_constant_load[mode];
  return point_count() > 0 ? load + system_.static_rows.col(mode).dot(point_force_) : load;
}

Eigen::VectorXd ModalStepper::State::displacement(int body) const {
  Eigen::VectorXd out = per_body(body, now_.q + rest_q_);
  for (std::size_t m = 0; m < system_.static_origin.size(); ++m) {
    const ModalOrigin origin = system_.static_origin[m];
    const auto at = static_cast<Eigen::Index>(m);
    if (origin.body == body) out[origin.index] = system_.static_compliance[at] * static_force(at);
  }
  return out;
}

Eigen::VectorXd ModalStepper::State::internal_force(int body) const {
  Eigen::VectorXd force;
  modal_internal_force(system_.poles, now_.z, force);
  Eigen::VectorXd out = per_body(body, force + rest_load_.matrix());
  for (std::size_t m = 0; m < system_.static_origin.size(); ++m) {
    const ModalOrigin origin = system_.static_origin[m];
    if (origin.body == body) out[origin.index] = static_force(static_cast<Eigen::Index>(m));
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
  energy.strain = 0.5 * (system_.relaxed_stiffness * now_.q.array().square()).sum() +
                  0.5 * rest_load_.matrix().dot(rest_q_) + rest_load_.matrix().dot(now_.q);
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
  for (int i = 0; i < point_count(); ++i) energy.contact_stored += stored_energy(i);
  return energy;
}

}  // namespace struna::fem
