#include "fem/newmark.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/band_cholesky.hpp"
#include "fem/contact_end_force.hpp"
#include "fem/contact_rest.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// y = A x without allocation.
void multiply_into(const BandMatrix& a, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  const int n = a.size();
  y.setZero(n);
  for (int j = 0; j < n; ++j) {
    const int reach = std::min(a.half_bandwidth(), n - 1 - j);
    const auto below = a.lower.col(j).segment(1, reach);
    y.segment(j + 1, reach) += x[j] * below;
    y[j] += a.lower(0, j) * x[j] + below.dot(x.segment(j + 1, reach));
  }
}

/// Newmark's constants for one step length: A = a0 M + a1 C + K, x1'' = a0 (x1 - x0) - a2 x0' - a3 x0'',
/// x1' = a1 (x1 - x0) - a4 x0' - a5 x0'' (Bathe, Finite Element Procedures, table 9.4).
struct NewmarkConstants {
  double step, a0, a1, a2, a3, a4, a5;

  NewmarkConstants(double h, double kappa, double lambda)
      : step(h),
        a0(1.0 / (kappa * h * h)),
        a1(lambda / (kappa * h)),
        a2(1.0 / (kappa * h)),
        a3(0.5 / kappa - 1.0),
        a4(lambda / kappa - 1.0),
        a5(h * (0.5 * lambda / kappa - 1.0)) {}
};

/// What one step length needs.
struct NewmarkTable {
  NewmarkConstants constants;
  std::vector<BandCholesky> dynamic_stiffness;  ///< per body
  std::vector<Eigen::MatrixXd> response;        ///< per body: A^-1 times the contact rows, dof x (2 points)
  RowMatrix flexibility;                        ///< (2 points) square
};

struct BodyState {
  Eigen::VectorXd x, v, a;
};

}  // namespace

class NewmarkStepper::State {
 public:
  State(std::vector<NodalBody> bodies, std::vector<ContactPoint> points, PrescribedMotion motion,
        const NewmarkOptions& options);

  void set_state(int body, const Eigen::VectorXd& displacement, const Eigen::VectorXd& velocity);
  std::vector<BandCholesky> follow_base();
  void settle();
  void advance(double time);
  int check_body(int body) const;
  int check_point(int point) const;

  double time_ = 0.0;
  std::vector<BodyState> now_;
  std::vector<double> force_;
  Eigen::VectorXd offset_, rate_, penetration_;
  StepReport report_;

 private:
  int point_count() const { return static_cast<int>(points_.size()); }
  Eigen::MatrixXd body_rows(int body) const;
  NewmarkTable make_table(double step) const;
  MotionSample motion_at(double time) const;
  void load_at(int body, const MotionSample& motion, Eigen::VectorXd& load) const;
  void measure(const std::vector<BodyState>& state, const MotionSample& motion);
  void set_acceleration();
  void free_step(const NewmarkTable& table, double end_time);
  void solve_contacts(const NewmarkTable& table);
  void finish_step(const NewmarkTable& table);
  void accept(double end_time, bool contact);
  bool closed() const { return point_count() > 0 && penetration_.maxCoeff() > 0.0; }
  void whole_step(const NewmarkTable& whole, const NewmarkTable& part, int parts, double end_time);

  std::vector<NodalBody> bodies_;
  std::vector<ContactPoint> points_;
  PrescribedMotion motion_;
  NewmarkOptions options_;
  std::vector<Eigen::MatrixXd> rows_;  ///< per body: dof x (2 points)
  std::vector<NewmarkTable> tables_;   ///< the step and the cut step
  std::vector<BodyState> next_;
  MotionSample next_motion_;
  Eigen::VectorXd next_offset_, next_rate_;
  Eigen::VectorXd y_, mass_y_, damping_y_, load_, contact_;
  bool accelerated_ = false;  ///< the present acceleration is known
};

NewmarkStepper::State::State(std::vector<NodalBody> bodies, std::vector<ContactPoint> points,
                             PrescribedMotion motion, const NewmarkOptions& options)
    : bodies_(std::move(bodies)), points_(std::move(points)), motion_(std::move(motion)), options_(options) {
  const auto fail = [](const std::string& what) { throw Error("NewmarkStepper: " + what); };
  if (!(options.step > 0.0) || !std::isfinite(options.step)) {
    fail(fmt::format("step must be positive, got {} s", options.step));
  }
  if (options.contact_substeps < 1) {
    fail(fmt::format("contact_substeps must be at least 1, got {}", options.contact_substeps));
  }
  if (!(options.lambda >= 0.5 && options.lambda <= 1.0)) {
    fail(fmt::format("lambda must lie between 1/2 and 1, got {}", options.lambda));
  }
  if (!(options.kappa >= 0.5 * options.lambda && options.kappa <= 1.0)) {
    fail(fmt::format("kappa must lie between lambda/2 and 1 (unconditional stability), got {} with lambda {}",
                     options.kappa, options.lambda));
  }
  if (bodies_.empty()) fail("at least 1 body, got 0");
  if (!motion_) fail("a motion is needed, got none");
  std::vector<int> dof;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const NodalBody& body = bodies_[b];
    const int n = body.mass.size();
    if (n == 0 || body.stiffness.lower.rows() != body.mass.lower.rows() || body.stiffness.size() != n ||
        body.load.rows() != n || (body.constant_load.size() != 0 && body.constant_load.size() != n)) {
      fail(fmt::format(
          "body {}: mass, stiffness, load and constant_load must have one size, got {}, {}, {} and {}", b, n,
          body.stiffness.size(), body.load.rows(), body.constant_load.size()));
    }
    dof.push_back(n);
    now_.push_back({Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)});
  }
  validate(points_, dof);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (points_[i].law.kind == ContactLaw::hard_stop) {
      fail(fmt::format("{}: hard_stop needs located impacts; use the modal method, or a stiff no_adhesion",
                       point_name(points_, i)));
    }
  }
  next_ = now_;
  for (std::size_t b = 0; b < bodies_.size(); ++b) rows_.push_back(body_rows(static_cast<int>(b)));
  tables_.push_back(make_table(options.step));
  if (options.contact_substeps > 1) tables_.push_back(make_table(options.step / options.contact_substeps));
  force_.assign(points_.size(), 0.0);
  contact_.setZero(2 * point_count());
  measure(now_, motion_at(0.0));
}

Eigen::MatrixXd NewmarkStepper::State::body_rows(int body) const {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(bodies_[body].mass.size(), 2 * point_count());
  for (int i = 0; i < point_count(); ++i) {
    if (points_[i].inside_body == body) rows.middleCols<2>(2 * i) += points_[i].inside;
    if (points_[i].outside_body == body) rows.middleCols<2>(2 * i) -= points_[i].outside;
  }
  return rows;
}

NewmarkTable NewmarkStepper::State::make_table(double step) const {
  NewmarkTable table{{step, options_.kappa, options_.lambda}, {}, {}, {}};
  const NewmarkConstants& n = table.constants;
  table.dynamic_stiffness.resize(bodies_.size());
  table.flexibility = RowMatrix::Zero(2 * point_count(), 2 * point_count());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const NodalBody& body = bodies_[b];
    if (!table.dynamic_stiffness[b].factorise(body.mass, n.a0 + n.a1 * body.rayleigh.alpha, body.stiffness,
                                              1.0 + n.a1 * body.rayleigh.beta)) {
      throw Error(fmt::format("NewmarkStepper: mass and stiffness of body {} must be positive definite", b));
    }
    Eigen::MatrixXd response = rows_[b];
    for (int j = 0; j < response.cols(); ++j) {
      if (response.col(j).any()) table.dynamic_stiffness[b].solve(response.col(j));
    }
    table.flexibility += rows_[b].transpose() * response;
    table.response.push_back(std::move(response));
  }
  return table;
}

MotionSample NewmarkStepper::State::motion_at(double time) const {
  const MotionSample motion = motion_(time);
  if (!std::isfinite(motion.displacement) || !std::isfinite(motion.velocity) ||
      !std::isfinite(motion.acceleration)) {
    throw Error(fmt::format("NewmarkStepper: the motion at t = {} s is not finite", time));
  }
  return motion;
}

int NewmarkStepper::State::check_body(int body) const {
  if (body < 0 || body >= static_cast<int>(bodies_.size())) {
    throw Error(fmt::format("NewmarkStepper: body must be one of {}, got {}", bodies_.size(), body));
  }
  return body;
}

int NewmarkStepper::State::check_point(int point) const {
  if (point < 0 || point >= point_count()) {
    throw Error(fmt::format("NewmarkStepper: contact point must be one of {}, got {}", point_count(), point));
  }
  return point;
}

void NewmarkStepper::State::load_at(int body, const MotionSample& motion, Eigen::VectorXd& load) const {
  const NodalBody& b = bodies_[body];
  load.noalias() = b.load.col(0) * motion.displacement;
  load += b.load.col(1) * motion.velocity + b.load.col(2) * motion.acceleration;
  if (b.constant_load.size()) load += b.constant_load;
}

/// Offsets, their rates and penetrations of all points at one instant.
void NewmarkStepper::State::measure(const std::vector<BodyState>& state, const MotionSample& motion) {
  offset_.resize(2 * point_count());
  rate_.resize(2 * point_count());
  penetration_.resize(point_count());
  for (int i = 0; i < point_count(); ++i) {
    offset_.segment<2>(2 * i) = points_[i].rest_offset + points_[i].motion * motion.displacement;
    rate_.segment<2>(2 * i) = points_[i].motion * motion.velocity;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    offset_.noalias() += rows_[b].transpose() * state[b].x;
    rate_.noalias() += rows_[b].transpose() * state[b].v;
  }
  for (int i = 0; i < point_count(); ++i) {
    penetration_[i] = contact_distance(points_[i].shape, &offset_[2 * i], 2) - points_[i].gap;
  }
}

void NewmarkStepper::State::set_state(int body, const Eigen::VectorXd& displacement,
                                      const Eigen::VectorXd& velocity) {
  BodyState& state = now_[check_body(body)];
  if (displacement.size() != state.x.size() || velocity.size() != state.x.size() ||
      !displacement.allFinite() || !velocity.allFinite()) {
    throw Error(fmt::format("set_state: body {} needs {} finite displacements and velocities, got {} and {}",
                            body, state.x.size(), displacement.size(), velocity.size()));
  }
  state.x = displacement;
  state.v = velocity;
  accelerated_ = false;
  measure(now_, motion_at(time_));
}

/// Returns the factors of each body's stiffness.
std::vector<BandCholesky> NewmarkStepper::State::follow_base() {
  const MotionSample motion = motion_at(time_);
  std::vector<BandCholesky> stiffness(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const NodalBody& body = bodies_[b];
    if (!stiffness[b].factorise(body.stiffness, 1.0, body.mass, 0.0)) {
      throw Error(fmt::format("settle: body {} is not held by its supports; it has no static rest", b));
    }
    now_[b].v = body.load.col(0) * motion.velocity;
    stiffness[b].solve(now_[b].v);
    now_[b].x = body.load.col(0) * motion.displacement;
    if (body.constant_load.size()) now_[b].x += body.constant_load;
    stiffness[b].solve(now_[b].x);
  }
  std::fill(force_.begin(), force_.end(), 0.0);
  contact_.setZero();
  measure(now_, motion);
  accelerated_ = false;
  return stiffness;
}

void NewmarkStepper::State::settle() {
  const std::vector<BandCholesky> stiffness = follow_base();
  RowMatrix flexibility = RowMatrix::Zero(2 * point_count(), 2 * point_count());
  std::vector<Eigen::MatrixXd> response;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    response.push_back(rows_[b]);
    for (int j = 0; j < response[b].cols(); ++j) stiffness[b].solve(response[b].col(j));
    flexibility += rows_[b].transpose() * response[b];
  }
  std::vector<ClosedContact> contacts(point_count());
  for (int i = 0; i < point_count(); ++i) {
    contacts[i].point = i;
    contacts[i].law = &points_[i].law;
    contacts[i].shape = points_[i].shape;
    contacts[i].gap = points_[i].gap;
    std::copy_n(&offset_[2 * i], 2, contacts[i].end_offset);
  }
  if (!rest_in_contact(contacts, 2, flexibility)) {
    throw Error("settle: the static equilibrium with contact was not found");
  }
  for (const ClosedContact& c : contacts) {
    force_[c.point] = c.force;
    for (int d = 0; d < 2; ++d) contact_[2 * c.point + d] = -c.direction[d] * c.force;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) now_[b].x += response[b] * contact_;
  measure(now_, motion_at(time_));
}

/// x'' from the balance at the present time.
void NewmarkStepper::State::set_acceleration() {
  const MotionSample motion = motion_at(time_);
  measure(now_, motion);
  for (int i = 0; i < point_count(); ++i) {
    const double size = contact_distance(points_[i].shape, &offset_[2 * i], 2);
    const Eigen::Vector2d n = points_[i].shape == StopShape::wall ? Eigen::Vector2d(Eigen::Vector2d::UnitX())
                              : size > 0.0 ? Eigen::Vector2d(offset_.segment<2>(2 * i) / size)
                                           : Eigen::Vector2d(Eigen::Vector2d::Zero());
    force_[i] = contact_force(points_[i].law, penetration_[i], n.dot(rate_.segment<2>(2 * i)));
    contact_.segment<2>(2 * i) = -force_[i] * n;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const NodalBody& body = bodies_[b];
    BandCholesky mass;
    if (!mass.factorise(body.mass, 1.0, body.stiffness, 0.0)) {
      throw Error(fmt::format("NewmarkStepper: the mass matrix of body {} must be positive definite", b));
    }
    load_at(static_cast<int>(b), motion, load_);
    y_ = now_[b].x + body.rayleigh.beta * now_[b].v;
    multiply_into(body.stiffness, y_, mass_y_);
    load_ += rows_[b] * contact_ - mass_y_;
    mass.solve(load_);
    now_[b].a = load_ - body.rayleigh.alpha * now_[b].v;
  }
  accelerated_ = true;
}

/// The end of a step without contact forces, with offsets and rates.
void NewmarkStepper::State::free_step(const NewmarkTable& table, double end_time) {
  const NewmarkConstants& n = table.constants;
  next_motion_ = motion_at(end_time);
  next_offset_.resize(2 * point_count());
  next_rate_.resize(2 * point_count());
  for (int i = 0; i < point_count(); ++i) {
    next_offset_.segment<2>(2 * i) = points_[i].rest_offset + points_[i].motion * next_motion_.displacement;
    next_rate_.segment<2>(2 * i) = points_[i].motion * next_motion_.velocity;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const NodalBody& body = bodies_[b];
    const BodyState& s = now_[b];
    load_at(static_cast<int>(b), next_motion_, load_);
    damping_y_ = n.a1 * s.x + n.a4 * s.v + n.a5 * s.a;
    y_ = n.a0 * s.x + n.a2 * s.v + n.a3 * s.a + body.rayleigh.alpha * damping_y_;
    multiply_into(body.mass, y_, mass_y_);
    load_ += mass_y_;
    if (body.rayleigh.beta > 0.0) {
      multiply_into(body.stiffness, damping_y_, mass_y_);
      load_ += body.rayleigh.beta * mass_y_;
    }
    next_[b].x = load_;
    table.dynamic_stiffness[b].solve(next_[b].x);
    next_[b].v = n.a1 * (next_[b].x - s.x) - n.a4 * s.v - n.a5 * s.a;
    if (point_count() == 0) continue;
    next_offset_.noalias() += rows_[b].transpose() * next_[b].x;
    next_rate_.noalias() += rows_[b].transpose() * next_[b].v;
  }
}

void NewmarkStepper::State::solve_contacts(const NewmarkTable& table) {
  const bool found = solve_end_forces(points_, table.flexibility, table.constants.a1, next_offset_,
                                      next_rate_, contact_, force_);
  if (!found) {
    throw Error(
        fmt::format("NewmarkStepper: contact forces at t = {} s did not converge; lower the step", time_));
  }
}

void NewmarkStepper::State::finish_step(const NewmarkTable& table) {
  const NewmarkConstants& n = table.constants;
  const bool touched = contact_.size() > 0 && contact_.any();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BodyState& s = now_[b];
    BodyState& e = next_[b];
    if (touched) {
      e.x += table.response[b] * contact_;
      e.v = n.a1 * (e.x - s.x) - n.a4 * s.v - n.a5 * s.a;
    }
    e.a = n.a0 * (e.x - s.x) - n.a2 * s.v - n.a3 * s.a;
  }
}

void NewmarkStepper::State::accept(double end_time, bool contact) {
  const double length = end_time - time_;
  std::swap(now_, next_);
  const Eigen::VectorXd before = penetration_;
  measure(now_, next_motion_);
  for (int i = 0; i < point_count(); ++i) report_.events += (before[i] > 0.0) != (penetration_[i] > 0.0);
  time_ = end_time;
  (contact ? report_.contact_steps : report_.free_steps) += 1;
  report_.shortest_step = report_.shortest_step == 0.0 ? length : std::min(report_.shortest_step, length);
  report_.longest_step = std::max(report_.longest_step, length);
  for (int i = 0; i < point_count(); ++i) {
    report_.largest_penetration = std::max(report_.largest_penetration, penetration_[i]);
    const double moved = (offset_.segment<2>(2 * i) - points_[i].rest_offset).norm();
    report_.largest_displacement = std::max(report_.largest_displacement, moved);
  }
  for (const BodyState& s : now_) {
    if (!s.x.allFinite()) {
      throw Error(fmt::format("NewmarkStepper: the solution is not finite at t = {} s", time_));
    }
  }
}

/// One step while open; `parts` steps where a contact is or becomes closed within it (the paper's cut).
void NewmarkStepper::State::whole_step(const NewmarkTable& whole, const NewmarkTable& part, int parts,
                                       double end_time) {
  if (!closed()) {
    free_step(whole, end_time);
    bool touches = false;
    for (int i = 0; i < point_count(); ++i) {
      touches = touches || contact_distance(points_[i].shape, &next_offset_[2 * i], 2) > points_[i].gap;
    }
    if (!touches) {
      contact_.setZero();
      std::fill(force_.begin(), force_.end(), 0.0);
      finish_step(whole);
      accept(end_time, false);
      return;
    }
    ++report_.rejected_steps;
  }
  const double start = time_;
  for (int i = 1; i <= parts; ++i) {
    const double end = i == parts ? end_time : start + (end_time - start) * i / parts;
    free_step(part, end);
    solve_contacts(part);
    finish_step(part);
    accept(end, true);
  }
}

void NewmarkStepper::State::advance(double time) {
  if (!(time >= time_) || !std::isfinite(time)) {
    throw Error(fmt::format("NewmarkStepper: advance must go forward from t = {} s, got {} s", time_, time));
  }
  if (!accelerated_) set_acceleration();
  const int parts = options_.contact_substeps;
  constexpr double rounding = 1e-6;  // of a step: a remainder below is rounding of the times, not a step
  const double start = time_;
  const double steps = (time - start) / options_.step;
  const long whole_steps = static_cast<long>(std::floor(steps + rounding));
  const bool remainder = steps - static_cast<double>(whole_steps) > rounding;
  for (long i = 1; i <= whole_steps; ++i) {
    const double end = i == whole_steps && !remainder ? time : start + static_cast<double>(i) * options_.step;
    whole_step(tables_.front(), tables_.back(), parts, end);
  }
  if (!remainder) {
    time_ = time;
    return;
  }
  const NewmarkTable whole = make_table(time - time_);
  const NewmarkTable part = make_table((time - time_) / parts);
  whole_step(whole, part, parts, time);
}

NewmarkStepper::NewmarkStepper(std::vector<NodalBody> bodies, std::vector<ContactPoint> points,
                               PrescribedMotion motion, const NewmarkOptions& options)
    : state_(std::make_unique<State>(std::move(bodies), std::move(points), std::move(motion), options)) {}
NewmarkStepper::~NewmarkStepper() = default;
NewmarkStepper::NewmarkStepper(NewmarkStepper&&) noexcept = default;
NewmarkStepper& NewmarkStepper::operator=(NewmarkStepper&&) noexcept = default;

void NewmarkStepper::set_state(int body, const Eigen::VectorXd& displacement,
                               const Eigen::VectorXd& velocity) {
  state_->set_state(body, displacement, velocity);
}
void NewmarkStepper::follow_base() {
  state_->follow_base();
}
void NewmarkStepper::settle() {
  state_->settle();
}
void NewmarkStepper::advance(double time) {
  state_->advance(time);
}
double NewmarkStepper::time() const {
  return state_->time_;
}
const Eigen::VectorXd& NewmarkStepper::displacement(int body) const {
  return state_->now_[state_->check_body(body)].x;
}
const Eigen::VectorXd& NewmarkStepper::velocity(int body) const {
  return state_->now_[state_->check_body(body)].v;
}
const Eigen::VectorXd& NewmarkStepper::acceleration(int body) const {
  return state_->now_[state_->check_body(body)].a;
}
double NewmarkStepper::penetration(int point) const {
  return state_->penetration_[state_->check_point(point)];
}
double NewmarkStepper::force(int point) const {
  return state_->force_[state_->check_point(point)];
}
Eigen::Vector2d NewmarkStepper::offset(int point) const {
  return state_->offset_.segment<2>(2 * state_->check_point(point));
}
const StepReport& NewmarkStepper::report() const {
  return state_->report_;
}

}  // namespace struna::fem
