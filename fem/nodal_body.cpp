#include "fem/nodal_body.hpp"

#include <fmt/format.h>

#include "fem/error.hpp"

namespace struna::fem {

NodalBody nodal_body(const Model& model, double youngs_modulus, const Rayleigh& rayleigh,
                     const std::vector<End>& moved, const Eigen::Vector3d& direction) {
  const int n = model.dof_count();
  Eigen::VectorXd carried = Eigen::VectorXd::Zero(n);
  for (const End end : moved) carried.segment<3>(first_dof(model, end)) = direction;
  for (const int dof : model.free_dof) {
    if (carried[dof] != 0.0) {
      throw Error(fmt::format("nodal_body: the moved support of '{}' must be held (clamped or pinned)",
                              model.body.name));
    }
  }
  const Eigen::VectorXd inertia = multiply(model.mass, carried);
  const Eigen::VectorXd elastic = youngs_modulus * multiply(model.stiffness, carried);
  NodalBody body;
  body.mass = submatrix(model.mass, model.free_dof);
  body.stiffness = submatrix(model.stiffness, model.free_dof);
  body.stiffness.lower *= youngs_modulus;
  body.rayleigh = rayleigh;
  body.load.resize(static_cast<Eigen::Index>(model.free_dof.size()), 3);
  for (std::size_t i = 0; i < model.free_dof.size(); ++i) {
    const int dof = model.free_dof[i];
    body.load.row(static_cast<Eigen::Index>(i)) << -elastic[dof],
        -rayleigh.alpha * inertia[dof] - rayleigh.beta * elastic[dof], -inertia[dof];
  }
  return body;
}

}  // namespace struna::fem
