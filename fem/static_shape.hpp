#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/eigenmodes.hpp"

namespace struna::fem {

/// Displacement of all dof when the supports at `ends` are moved by 1 m along `direction` (unit vector),
/// slowly and without other loads: K1 S = 0 on the free dof. From the modal sum over all modes of the model
/// (`modes` must be complete); rigid modes, which any such motion leaves undetermined, are left at rest. With
/// one modulus for the body it does not depend on the modulus. Zero when `ends` is empty. Throws Error where
/// an end is not held.
Eigen::VectorXd static_shape(const Model& model, const Eigenmodes& modes, const std::vector<End>& ends,
                             const Eigen::Vector3d& direction);

}  // namespace struna::fem
