#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "fem/contact_geometry.hpp"
#include "fem/motion.hpp"
#include "fem/pole_system.hpp"

namespace struna::fem {

/// A body in its modes, mass-normalised, driven by the prescribed motion (or force) u(t):
///   modal load p = load.col(0) u + load.col(1) u' + load.col(2) u'' + constant_load.
/// For a body whose supports move by psi u and whose modes describe the displacement relative to psi u:
/// load.col(2) = -Gamma, load.col(1) = -alpha Gamma, Gamma = Phi^T M psi (alpha acts on absolute velocities;
/// beta's part cancels because K psi = 0).
struct ModalBody {
  PoleSystem poles;
  Eigen::MatrixX3d load;          ///< modes x 3
  Eigen::VectorXd constant_load;  ///< modes; gravity. Empty: none
};

/// u(t) with its derivatives; MotionHistory::at fits.
using PrescribedMotion = std::function<MotionSample(double)>;

struct ModalSteppingOptions {
  double tolerance =
      1e-3;  ///< of the largest displacement; steps and modes follow from it, unless `step` fixes them
  double step = 0.0;          ///< fixed step in free flight [s]; 0: from the tolerance
  int contact_substeps = 5;   ///< fixed step in contact: step/contact_substeps (with `step` only)
  double longest_step = 0.0;  ///< bound for steps from the tolerance [s]; 0: none but the load's smoothness
  double highest_mode_hz = 0.0;  ///< modes above keep only their static flexibility; 0: every mode is stepped
  double displacement_scale =
      0.0;  ///< the largest displacement if known [m]; 0: the largest so far, at least the gap/10
  bool keep_events = true;  ///< false: events are counted, not kept
};

struct ContactEvent {
  enum class Kind { touch, approach_ends, approach_resumes, force_ends, force_resumes, open, impact };
  double time = 0.0;  ///< [s]
  int point = 0;      ///< index of the ContactPoint
  Kind kind = Kind::touch;
  double rate = 0.0;  ///< of the penetration just before [m/s]
};

/// Where the energy went [J], in the frame that moves with the static shape. Input is the work of the load.
/// Closes by itself: every entry is computed on its own.
struct EnergyLedger {
  double initial = 0.0;
  double input = 0.0;
  double kinetic = 0.0;
  double strain = 0.0;
  double contact_stored = 0.0;
  double body_dissipated = 0.0;
  double contact_dissipated = 0.0;
  double static_jumps =
      0.0;  ///< taken (or given: negative) where modes without mass follow a force that jumps
  double imbalance() const {
    return initial + input - kinetic - strain - contact_stored - body_dissipated - contact_dissipated -
           static_jumps;
  }
};

struct StepReport {
  long free_steps = 0;
  long contact_steps = 0;
  long rejected_steps = 0;  ///< repeated: an event inside, or the estimated error too large
  long events = 0;
  long lasting_contacts = 0;          ///< impacts on a hard stop that became lasting contacts
  int modes = 0;                      ///< stepped exactly
  int static_modes = 0;               ///< represented by their static flexibility
  int idle_modes = 0;                 ///< never excited: left out (a wire shaken in one plane)
  bool planar = false;                ///< every contact point moves on a line
  double shortest_step = 0.0;         ///< [s]
  double longest_step = 0.0;          ///< [s]
  double largest_penetration = 0.0;   ///< [m]
  double largest_displacement = 0.0;  ///< of a contact point relative to its counterpart [m]
};

/// Steps modal bodies exactly between events, contacts condensed to the gaps that are closed.
///
/// Within a step the contact forces are constant, F = k (g0 + g1)/2 + c (g1 - g0)/h along (h0 + h1)/(|h0| +
/// |h1|): the discrete gradient of Gonzalez (J. Nonlinear Sci. 6 (1996) 449) together with the exact
/// exponential of the modes, so elastic contact neither gains nor loses energy at any step; second order. The
/// load enters by its exact mean and first moment over the step. Touch, end of approach, end of force and
/// opening are located and stepped to.
class ModalStepper {
 public:
  /// Throws Error on sizes that do not fit, values that are not finite or poles that grow.
  ModalStepper(std::vector<ModalBody> bodies, std::vector<ContactPoint> points, PrescribedMotion motion,
               const ModalSteppingOptions& options = {});
  ~ModalStepper();
  ModalStepper(ModalStepper&&) noexcept;
  ModalStepper& operator=(ModalStepper&&) noexcept;

  /// Modal displacements and velocities of one body at the present time, internal variables relaxed to the
  /// displacement. A new stepper has both at zero: the static shape moving with the base.
  void set_state(int body, const Eigen::VectorXd& displacement, const Eigen::VectorXd& velocity);
  /// Static equilibrium under the constant loads, contact included, at u(t): the start with gravity.
  void settle();

  /// Steps to exactly `time` >= time(). Throws Error when the motion is not finite or the solution leaves
  /// finite values.
  void advance(double time);
  double time() const;

  /// Per body, size = its modes; idle modes are zero, static modes follow the contact forces.
  Eigen::VectorXd displacement(int body) const;
  Eigen::VectorXd velocity(int body) const;
  /// Internal (elastic and damping) modal force, p - q'': with K phi_r/omega_r^2 the support reactions follow
  /// from it.
  Eigen::VectorXd internal_force(int body) const;

  /// Per contact point at the present time: penetration g [m] (negative: open), force [N] and offset h [m].
  double penetration(int point) const;
  double force(int point) const;
  Eigen::Vector2d offset(int point) const;

  const std::vector<ContactEvent>& events() const;
  const StepReport& report() const;
  EnergyLedger energy() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace struna::fem
