#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/band_matrix.hpp"
#include "fem/material.hpp"
#include "fem/model.hpp"

namespace struna::fem {

/// A body in its free nodal dof, M x'' + C x' + K x = load.col(0) u + load.col(1) u' + load.col(2) u'' +
/// constant_load, with C = alpha M + beta K. For moved supports (dof p, moved by d u): load = -K_fp d, -C_fp
/// d, -M_fp d.
struct NodalBody {
  BandMatrix mass;
  BandMatrix stiffness;
  Rayleigh rayleigh;
  Eigen::MatrixX3d load;          ///< dof x 3
  Eigen::VectorXd constant_load;  ///< dof; gravity. Empty: none
};

/// The free dof of a model in nodal form, K = youngs_modulus K1, with supports `moved` along `direction`.
NodalBody nodal_body(const Model& model, double youngs_modulus, const Rayleigh& rayleigh,
                     const std::vector<End>& moved, const Eigen::Vector3d& direction);

}  // namespace struna::fem
