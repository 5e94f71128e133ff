#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/band_matrix.hpp"
#include "fem/body.hpp"

namespace struna::fem {

/// The discretised body: matrices over all dof, supports included (6 per node, node-major), for unit modulus.
/// A support that gives in translation has a base of six held dof besides, beyond its node, which is moved
/// and whose force is read; the end hangs on it by springs.
struct Model {
  Body body;
  std::vector<double> arc_length;         ///< of the nodes [m], elements + 1 of them
  std::vector<Eigen::Vector3d> position;  ///< of the nodes [m]
  BandMatrix stiffness;                   ///< K1: K = E(f) K1
  BandMatrix mass;
  std::vector<int> free_dof;  ///< increasing
  std::vector<int> held_dof;  ///< increasing; the dof that supports hold

  int start_bases = 0;  ///< 0 or 1
  int end_bases = 0;

  int dof_count() const { return 6 * (static_cast<int>(arc_length.size()) + start_bases + end_bases); }
  int node_dof(int node) const { return 6 * (start_bases + node); }  ///< the first of a node's six
};

/// Assembles a body with `elements` equal arc lengths (body.elements when 0; throws Error when both are 0).
Model assemble(const Body& body, int elements = 0);

enum class End { start, end };

/// First of the six dof of the support at an end: its base's where it has one, else the last node's.
int first_dof(const Model& model, End end);

/// Where a fraction of the arc length (0..1) lies: weights w over all dof so that (w . q) is the displacement
/// there along the unit vector `direction` (the element's shape functions; exact at nodes).
Eigen::VectorXd point_functional(const Model& model, double fraction, const Eigen::Vector3d& direction);

}  // namespace struna::fem
