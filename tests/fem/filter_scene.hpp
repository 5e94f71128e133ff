#pragma once

#include "fem/simulation.hpp"

namespace struna::fem {

inline Material viscous_material(double youngs_modulus, double alpha = 43.1) {
  Material material;
  material.youngs_modulus = constant_law(youngs_modulus);
  material.rayleigh = {alpha, 2e-6};
  material.damping = Damping::viscous;
  return material;
}

/// The straight wire of the mechanical filter.
inline Body wire() {
  return {"wire",
          straight_line({0, 0, 0}, {0.501, 0, 0}),
          {8.042477e-6, 3.1083e-12, 6.2166e-12},
          7650.0,
          0.3,
          viscous_material(100e9),
          25,
          EndCondition::clamped,
          EndCondition::clamped};
}

inline Body band() {
  return {"band",
          straight_line({0.120, 0, 0}, {0.441, 0, 0}),
          {6.126106e-5, 3.9245e-10, 7.849e-10},
          4535.0,
          0.3,
          viscous_material(60e9),
          16,
          EndCondition::clamped,
          EndCondition::clamped};
}

inline Body curved_wire() {
  Body body = wire();
  body.centreline = spline_through(
      {{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}, {0.52, -0.05, 0.13}, {0.62, -0.02, 0.16}}, 0.68);
  return body;
}

inline Scene bare_scene(const Body& body, Excitation::Kind kind, double duration) {
  Scene scene;
  scene.bodies = {body};
  scene.drive = SceneDrive{Support{"wire", End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement =
      SceneMeasurement{Support{"wire", End::end},
                       MotionQuantity::displacement,
                       {"force_x", "force_y", "force_z"},
                       {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}};
  Simulation simulation;
  simulation.duration = duration;
  simulation.excitation.kind = kind;
  simulation.excitation.band_lo_hz = 10.0;
  simulation.excitation.band_hi_hz = 1000.0;
  simulation.excitation.frequency_hz = 50.0;
  simulation.excitation.acceleration = 10.0;
  simulation.excitation.rms_acceleration = 20.0;
  scene.simulation = simulation;
  return scene;
}

inline Scene banded_scene(Excitation::Kind kind, double duration, double gap) {
  Scene scene = bare_scene(wire(), kind, duration);
  scene.bodies.push_back(band());
  Contact contact;
  contact.inside = "wire";
  contact.outside = "band";
  contact.gap = gap;
  contact.stiffness = 1e5;
  contact.damping = 100.0;
  scene.contacts = {contact};
  return scene;
}

inline TimeResponse simulated(const Scene& scene) {
  return simulate(scene, scene_motion(scene));
}

}  // namespace struna::fem
