#include "ident/separable_minimum.hpp"

#include <Eigen/Cholesky>

namespace struna::ident {

Eigen::VectorXd damped_step(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& gradient, double damping) {
  Eigen::MatrixXd lhs = hessian;
  lhs.diagonal() *= 1.0 + damping;
  return lhs.ldlt().solve(gradient);
}

}  // namespace struna::ident
