#pragma once

#include <string>
#include <vector>

#include "fem/body_dynamics.hpp"
#include "fem/scene.hpp"
#include "fem/sizing.hpp"

namespace struna::fem {

/// A body that takes part in a simulation, in the coordinates of the scene's method.
struct PlannedBody {
  MeshChoice mesh;
  Model model;
  Eigenmodes modes;  ///< complete
  BodyDrive drive;
  Coordinates coordinates;
};

/// A scene made ready for stepping: the bodies that can matter, their possible contact points, the outputs.
struct SimulationPlan {
  std::vector<PlannedBody> bodies;
  int measured_body = 0;
  std::vector<JoinedPair> pairs;
  std::vector<ContactPoint> points;      ///< one per pair
  std::vector<const Contact*> contacts;  ///< of the scene, one per pair (borrowed from the scene)
  std::vector<OutputRow> rows;
  double overlap = 0.0;          ///< deepest penetration as drawn [m]
  double fastest_contact = 0.0;  ///< largest angular frequency of a contact's spring at a point [1/s]
  std::vector<std::string> warnings;
};

/// Bodies of the scene that the measured one is joined to by contacts, itself included; contacts between
/// others are left out. Elements follow from `highest_hz` and the tolerance where a body leaves them open.
/// The scene must outlive the plan. Throws Error on a scene without drive, measurement or simulation, and
/// where nothing moves the measured body.
SimulationPlan plan_simulation(const Scene& scene, double highest_hz);

}  // namespace struna::fem
