#pragma once

#include <Eigen/Core>

#include "fem/eigenmodes.hpp"

namespace struna::fem {

/// The lowest `count` modes of a body (all of them when 0), those of a straight one sorted into its planes:
/// bending across `direction` (its part normal to the axis), bending across the third axis, stretch and
/// torsion are solved apart. A straight wire bends alike in every plane, so a common solution would return
/// arbitrary mixtures of each pair, and shaking one plane would seem to move the other. Curved bodies: the
/// same as solve_eigenmodes(model, count).
Eigenmodes solve_plane_modes(const Model& model, const Eigen::Vector3d& direction, int count = 0);

}  // namespace struna::fem
