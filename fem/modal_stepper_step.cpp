#include <fmt/format.h>

#include "fem/error.hpp"
#include "fem/modal_stepper_state.hpp"

namespace struna::fem {

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

/// The blocks of the closed points out of a matrix between all of them.
static void gather_closed(const RowMatrix& all, const std::vector<ClosedContact>& closed, int d,
                          RowMatrix& block) {
  const int n = static_cast<int>(closed.size());
  block.resize(n * d, n * d);
  for (int i = 0; i < n; ++i) {
    for (int r = 0; r < d; ++r) {
      const double* from = &all(closed[i].point * d + r, 0);
      double* to = &block(i * d + r, 0);
      for (int j = 0; j < n; ++j) {
        for (int c = 0; c < d; ++c) *to++ = from[closed[j].point * d + c];
      }
    }
  }
}

void ModalStepper::State::closed_flexibility(const StepTable& table) {
  const int d = system_.dimension;
  const int n = static_cast<int>(closed_.size());
  if (system_.static_flexibility.size()) {
    gather_closed(system_.static_flexibility, closed_, d, closed_static_);
  }
  if (table.flexibility.size()) {
    gather_closed(table.flexibility, closed_, d, closed_flexibility_);
    return;
  }
  closed_rows_.resize(n * d, system_.poles.modes);
  for (int i = 0; i < n; ++i)
    closed_rows_.middleRows(i * d, d) = system_.rows.middleRows(closed_[i].point * d, d);
  scaled_rows_ = closed_rows_ * table.coefficients.flexibility.matrix().asDiagonal();
  closed_flexibility_.noalias() = scaled_rows_ * closed_rows_.transpose();
  if (closed_static_.size()) closed_flexibility_ += closed_static_;
}

/// Mean and slope of the modal loads over a step: exact mean and first moment of u'' from u' and u at the
/// ends; u' and u by the cubic of Hermite.
void ModalStepper::State::load_over(double step, const MotionSample& end) {
  const StepLoad load = step_load(now_.motion, end, step);
  mean_ = system_.constant_load - rest_load_;
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
  next_.offset += rest_offset_ + system_.motion * next_.motion.displacement;
  closed_.clear();
  start_offset_ = now_.offset;
  if (system_.static_flexibility.size()) {
    start_offset_.noalias() -= system_.static_flexibility * point_force_;
  }
  for (int i = 0; i < point_count(); ++i) {
    if (!transmits(phase_[i])) continue;
    const int d = system_.dimension;
    ClosedContact contact;
    contact.point = i;
    contact.law = &points_[i].law;
    contact.phase = phase_[i];
    contact.shape = points_[i].shape;
    contact.gap = points_[i].gap;
    std::copy_n(&start_offset_[i * d], d, contact.start_offset);
    std::copy_n(&next_.offset[i * d], d, contact.end_offset);
    contact.prior_penetration = now_.penetration[i];
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
  const Eigen::VectorXd offset = start_offset_ + system_.static_flexibility * next_point_force_;
  for (int i = 0; i < point_count(); ++i) {
    path_start_[i] = contact_distance(points_[i].shape, &offset[i * d], d) - points_[i].gap;
  }
}

void ModalStepper::State::solve_contacts(const StepTable& table) {
  const StepCoefficients& c = table.coefficients;
  const int d = system_.dimension;
  closed_flexibility(table);
  if (!solver_.solve(closed_, d, closed_flexibility_, closed_static_, c.step)) {
    throw NotConverged(fmt::format(
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
  next_.offset += rest_offset_ + system_.motion * next_.motion.displacement;
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
  energy_.input += work.load_work + rest_load_.matrix().dot(next_.q - now_.q);
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
    // Static modes jump with the force at the start of a step, and the contact's springs with them. They have
    // no mass to carry what is lost or won in that.
    const RowMatrix& flexibility = system_.static_flexibility;
    energy_.static_jumps += 0.5 * (point_force_.dot(flexibility * point_force_) -
                                      next_point_force_.dot(flexibility * next_point_force_));
    for (const ClosedContact& closed : closed_) {
      energy_.static_jumps += spring_energy(*closed.law, closed.prior_penetration) -
                                 spring_energy(*closed.law, closed.start_penetration);
    }
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
  }
  if (!std::isfinite(now_.q.sum())) {
    throw Error(fmt::format("ModalStepper: the solution is not finite at t = {} s", time_));
  }
}

}  // namespace struna::fem
