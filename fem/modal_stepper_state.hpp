#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "fem/contact_events.hpp"
#include "fem/contact_solver.hpp"
#include "fem/error.hpp"
#include "fem/modal_stepping.hpp"
#include "fem/modal_system.hpp"
#include "fem/pole_stepping.hpp"
#include "fem/step_control.hpp"

namespace struna::fem {

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

/// Contact forces of a step that were not found: a shorter one may have them.
class NotConverged : public Error {
 public:
  using Error::Error;
};

/// The inside of a ModalStepper. State and what can be read: modal_stepper_state.cpp; one step of given
/// length: modal_stepper_step.cpp; events and the choice of steps: modal_stepping.cpp.
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
  double static_force(Eigen::Index mode) const;
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
  void deflect_static_modes();
  void balance(const Eigen::VectorXd& offset, const RowMatrix& w);
  void refuse_falling(const Eigen::ArrayXd& load) const;
  void start_ledger();
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
  double stored_energy(int point) const;
  void strike(int point, double approach_speed);
  void check_resolved(int point) const;
  bool in_contact() const;
  void step_toward(double target);

  std::vector<ModalBody> bodies_;
  std::vector<ContactPoint> points_;
  PrescribedMotion motion_;
  ModalSteppingOptions options_;
  std::vector<Eigen::VectorXcd> stored_poles_;  ///< z per body, of modes that are not stepped now too
  std::vector<std::vector<char>> moving_;

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
  RowMatrix closed_flexibility_, closed_static_, closed_rows_, scaled_rows_;
  Eigen::VectorXd rest_q_;  ///< the static rest that z counts from: modes, modal load, offsets without z
  Eigen::ArrayXd rest_load_;
  Eigen::VectorXd rest_offset_;
  Eigen::VectorXd start_offset_;  ///< at the start of the attempted step, static modes undeflected
  Eigen::VectorXd point_force_;   ///< on the components, now: the static deflection follows it
  Eigen::VectorXd next_point_force_;
  Eigen::ArrayXd mean_, slope_, contact_load_;
  EnergyLedger energy_;
  bool drives_[3] = {};
  int stalled_ = 0;      ///< events in a row without a step between
  bool frozen_ = false;  ///< one step without event search, after a stall
};

inline bool finite(const MotionSample& m) {
  return std::isfinite(m.displacement) && std::isfinite(m.velocity) && std::isfinite(m.acceleration);
}

}  // namespace struna::fem
