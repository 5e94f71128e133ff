#pragma once

#include <Eigen/Core>

namespace struna::fem {

/// Gauss-Legendre rule on [0, 1]: sum of weight(i) f(node(i)), exact for polynomials up to degree 2 n - 1.
struct GaussRule {
  Eigen::VectorXd node;
  Eigen::VectorXd weight;
};

/// The rule with `points` >= 1 nodes (Newton on the Legendre recurrence; Davis & Rabinowitz, Methods of
/// Numerical Integration, 2nd ed., section 2.7).
GaussRule gauss_legendre(int points);

/// A with (A f(nodes))(i) = integral of f from 0 to node(i), exact for the polynomial through the nodes'
/// values.
Eigen::MatrixXd integration_matrix(const Eigen::VectorXd& nodes);

}  // namespace struna::fem
