#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "fem/contact_geometry.hpp"
#include "fem/modal_stepping.hpp"
#include "fem/nodal_body.hpp"

namespace struna::fem {

struct NewmarkOptions {
  double step = 1e-5;        ///< [s]
  int contact_substeps = 5;  ///< the paper's cut while any contact is closed
  double kappa = 0.25;       ///< beta_N
  double lambda = 0.5;       ///< gamma; > 1/2 adds numerical damping
};

/// Newmark's scheme (28)-(30) for bodies in nodal dof, banded, with the contact force of a step solved
/// implicitly (condensed to the closed gaps). Second order without contact; with it first order at best,
/// because touch is not located (see modal_stepping for that).
class NewmarkStepper {
 public:
  /// Throws Error on sizes that do not fit, step <= 0, substeps < 1, lambda < 1/2 or kappa < lambda/2 (only
  /// unconditionally stable schemes are offered).
  NewmarkStepper(std::vector<NodalBody> bodies, std::vector<ContactPoint> points, PrescribedMotion motion,
                 const NewmarkOptions& options = {});
  ~NewmarkStepper();
  NewmarkStepper(NewmarkStepper&&) noexcept;
  NewmarkStepper& operator=(NewmarkStepper&&) noexcept;

  /// Displacement and velocity of one body at the present time; acceleration follows from balance at the next
  /// step.
  void set_state(int body, const Eigen::VectorXd& displacement, const Eigen::VectorXd& velocity);
  /// The static shape at u(t) under the constant loads, as if there were no contacts, moving with the base:
  /// x' = static shape times u'. Throws Error where a body is not held.
  void follow_base();
  /// The same with the contacts: their static equilibrium at u(t).
  void settle();

  /// Steps to `time`: whole steps, the last one shortened where needed.
  void advance(double time);
  double time() const;

  const Eigen::VectorXd& displacement(int body) const;
  const Eigen::VectorXd& velocity(int body) const;
  const Eigen::VectorXd& acceleration(int body) const;

  double penetration(int point) const;
  double force(int point) const;
  Eigen::Vector2d offset(int point) const;

  const StepReport& report() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace struna::fem
