#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/contact_geometry.hpp"
#include "fem/modal_system.hpp"

namespace struna::fem {

/// Contact forces at the end of an implicit step, each point meeting its own law:
///   h = offset + W f,   h' = rate + rate_factor W f,   f = -F h/|h| (two components per point).
/// Gauss-Seidel over the points; the dashpot's jump at touch counts as a step of the law, on which a point
/// may end (g = 0). W is positive definite and the laws rise with penetration, so it converges. `offset` and
/// `rate` are those without contact and are used up. False: not converged.
bool solve_end_forces(const std::vector<ContactPoint>& points, const RowMatrix& flexibility,
                      double rate_factor, Eigen::VectorXd& offset, Eigen::VectorXd& rate,
                      Eigen::VectorXd& point_force, std::vector<double>& force);

}  // namespace struna::fem
