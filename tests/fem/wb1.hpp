#pragma once

#include <cmath>
#include <numbers>

#include "bodies.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/modal_stepping.hpp"
#include "fem/newmark.hpp"

// The benchmark WB-1: a clamped straight wire of 28 elements, shaken sideways with 20 sin(2 pi 25 t) m/s^2,
// against a one-sided stop at its middle, gap 1 mm, F = max(0, 1e5 g + 100 g'). Displacements and velocities
// are relative to the base, C = 2 M + 1e-5 K acts on them (so u' loads nothing); start at rest. Reference:
// regime eigen-solutions joined at bisected events, confirmed by an independent BDF integration to 1.1e-6 of
// the gap.
namespace struna::fem::testing {

constexpr double wb1_gap = 1e-3;
constexpr double wb1_frequency = 25.0;
constexpr int wb1_elements = 28;

inline MotionSample wb1_motion(double t) {
  const double omega = 2.0 * std::numbers::pi * wb1_frequency;
  return {-20.0 / (omega * omega) * std::sin(omega * t), -20.0 / omega * std::cos(omega * t),
          20.0 * std::sin(omega * t)};
}

inline Body wb1_wire() {
  Body body = straight_wire();
  body.material.rayleigh = {2.0, 1e-5};
  body.material.damping = Damping::viscous;
  return body;
}

inline ContactPoint wb1_stop() {
  ContactPoint stop;
  stop.law = {ContactLaw::no_adhesion, 1e5, 100.0};
  stop.gap = wb1_gap;
  stop.shape = StopShape::wall;
  return stop;
}

/// M times a unit translation along y: the load of a base acceleration is its negative.
inline Eigen::VectorXd wb1_inertia(const Model& model) {
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(model.dof_count());
  for (int i = 1; i < unit.size(); i += 6) unit[i] = 1.0;
  return multiply(model.mass, unit);
}

struct Wb1Modal {
  ModalBody body;
  ContactPoint stop = wb1_stop();

  Wb1Modal() {
    const Model model = assemble(wb1_wire(), wb1_elements);
    const Eigenmodes modes = solve_eigenmodes(model);
    body.poles = pole_system(model, modes, Damping::viscous, 1e4);
    body.load = Eigen::MatrixX3d::Zero(modes.shape.cols(), 3);
    body.load.col(2) = -modes.shape.transpose() * wb1_inertia(model);
    stop.inside = Eigen::MatrixX2d::Zero(modes.shape.cols(), 2);
    stop.inside.col(0) = modes.shape.row(6 * (wb1_elements / 2) + 1).transpose();
  }
  ModalStepper stepper(const ModalSteppingOptions& options) const {
    return ModalStepper({body}, {stop}, wb1_motion, options);
  }
};

struct Wb1Nodal {
  NodalBody body;
  ContactPoint stop = wb1_stop();

  Wb1Nodal() {
    const Model model = assemble(wb1_wire(), wb1_elements);
    body = nodal_body(model, wire_modulus, {2.0, 1e-5}, {}, Eigen::Vector3d::UnitY());
    const Eigen::VectorXd inertia = wb1_inertia(model);
    stop.inside = Eigen::MatrixX2d::Zero(body.mass.size(), 2);
    for (std::size_t i = 0; i < model.free_dof.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      body.load(row, 2) = -inertia[model.free_dof[i]];
      if (model.free_dof[i] == 6 * (wb1_elements / 2) + 1) stop.inside(row, 0) = 1.0;
    }
  }
  NewmarkStepper stepper(const NewmarkOptions& options) const {
    return NewmarkStepper({body}, {stop}, wb1_motion, options);
  }
};

struct Wb1Value {
  double time, displacement;
};
constexpr Wb1Value wb1_displacement[] = {{.05, -2.459170631399e-3},
                                         {.1, -1.417338782034e-3},
                                         {.2, -6.942613889556e-4},
                                         {.3, -1.333040056768e-3},
                                         {.5, -1.309730015563e-3}};

}  // namespace struna::fem::testing
