#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/contact_geometry.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/modal_stepping.hpp"
#include "fem/model.hpp"
#include "fem/pole_system.hpp"
#include "fem/scene.hpp"

namespace struna::fem {

/// What moves a body of a scene from outside: its supports with the prescribed motion u(t) [m], or a force
/// u(t) [N].
struct BodyDrive {
  std::vector<End> moved;  ///< supports that follow u; empty: none
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();
  Eigen::VectorXd force;                              ///< load over all dof per unit u; empty: none
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// What the scene's drive and gravity do to one of its bodies.
BodyDrive body_drive(const Scene& scene, const Model& model);

/// The coordinates x in which a body is stepped: displacement of all dof q = basis x + carried u.
struct Coordinates {
  Eigen::MatrixXd basis;    ///< all dof x coordinates
  Eigen::VectorXd carried;  ///< what the coordinates are relative to, per unit u
};
/// Mass-normalised modes relative to the static shape of the moved supports: u enters by inertia alone.
Coordinates modal_coordinates(const Model& model, const Eigenmodes& complete_modes, const BodyDrive& drive);
/// The free dof themselves.
Coordinates nodal_coordinates(const Model& model, const BodyDrive& drive);

/// Loads over all dof of a uniform acceleration: M g, held rows included.
Eigen::VectorXd gravity_load(const Model& model, const Eigen::Vector3d& gravity);

/// The body for ModalStepper, in modal_coordinates().
ModalBody modal_body(const Model& model, const Eigenmodes& complete_modes, const Coordinates& coordinates,
                     const BodyDrive& drive, double band_hi_hz);

/// A contact pair in the coordinates of two bodies.
ContactPoint contact_point(const ContactPair& pair, const Contact& contact, const Coordinates& inside,
                           const Coordinates& outside, int inside_body, int outside_body);

/// A measured quantity as a sum over the state of its body,
///   y = on_displacement . x + on_velocity . x' + on_acceleration . x'' + on_motion . (u, u', u'')
///       + static_stiffness (E* u) + sum over contact points on_contact . f + constant,
/// f the contact force on the inside body in the point's plane, E* u the modulus (with its memory) acting on
/// u.
///
/// A support's force is not summed from the stiffness rows, which converge slowly, but from momentum: with S
/// the static shape of a unit motion of the measured support, R = S^T (M q'' + C q' + K q - F), where S^T K q
/// = (S^T K S_drive) u. Loads that the coordinates cannot follow arrive through S with their static share.
/// docs/simulation.md.
struct OutputRow {
  Eigen::VectorXd on_displacement;
  Eigen::VectorXd on_velocity;
  Eigen::VectorXd on_acceleration;
  Eigen::Vector3d on_motion = Eigen::Vector3d::Zero();
  double static_stiffness = 0.0;  ///< per unit modulus [m]
  Eigen::MatrixX2d on_contact;    ///< contact points x 2; zero rows for points on other bodies
  double constant = 0.0;
};

/// A contact pair and the bodies that it joins, by index.
struct JoinedPair {
  ContactPair pair;
  int inside_body = 0;
  int outside_body = 0;
};

/// One row per measured direction. `body` is the measured body's index. The modes must be complete.
std::vector<OutputRow> output_rows(const SceneMeasurement& measurement, const Model& model,
                                   const Eigenmodes& complete_modes, const Coordinates& coordinates,
                                   const BodyDrive& drive, const std::vector<JoinedPair>& pairs, int body);

/// (E* u)(t) [Pa m] along a history of u, step by step; at rest in u's first value.
class ModulusMemory {
 public:
  ModulusMemory(const MaxwellLaw& law, const MotionSample& start);
  /// Goes on by `interval` [s] to a new value of u (u between them linear).
  double advance(double interval, const MotionSample& u);
  double value() const { return value_; }

 private:
  double evaluate(const MotionSample& u) const;

  MaxwellLaw law_;
  Eigen::VectorXd internal_;  ///< x_j, tau_j x_j' = u - x_j
  double last_ = 0.0;
  double value_ = 0.0;
};

}  // namespace struna::fem
