#pragma once

#include "fem/harmonic.hpp"
#include "fem/sizing.hpp"

namespace struna::fem {

/// A harmonic response on a mesh that was chosen for it.
struct SizedResponse {
  Model model;
  HarmonicResponse response;
  MeshRequest request;
  MeshChoice mesh;             ///< the one used; its estimate is the a priori one
  double checked_error = 0.0;  ///< found on twice the elements, relative to all outputs on the worst line
  int refinements = 0;         ///< meshes that the check refused
};

/// Steady state on the body's elements, or on the mesh that choose_mesh() takes for the tolerance. Then on
/// twice the elements at up to 80 of the lines (the steepest of each part of the band, where a shift shows
/// most): where that tells of an error beyond the tolerance, and the body leaves its elements open, solved
/// again on a finer mesh, twice at most. Not so without damping: a resonance on a line is without bound.
/// Throws as harmonic_response() and choose_mesh().
SizedResponse sized_response(const Body& body, const Drive& drive, const Measurement& measurement,
                             const Eigen::VectorXd& frequency_hz, Damping damping, double tolerance);

}  // namespace struna::fem
