#pragma once

#include <Eigen/Core>

#include "fem/band_matrix.hpp"

namespace struna::fem {

/// L L^T of a symmetric positive definite band matrix, for one right-hand side at a time.
class BandCholesky {
 public:
  /// Factorises s_a A + s_b B (one size and bandwidth). False where it is not positive definite.
  bool factorise(const BandMatrix& a, double s_a, const BandMatrix& b, double s_b);
  /// Solves in place.
  void solve(Eigen::Ref<Eigen::VectorXd> x) const;
  /// x with covariance (L L^T)^-1 from an x of independent unit variances, in place: L^-T x.
  void colour(Eigen::Ref<Eigen::VectorXd> x) const;
  /// ln of the determinant of what was factorised.
  double log_determinant() const { return -2.0 * lower_.row(0).array().log().sum(); }

 private:
  Eigen::MatrixXd lower_;  ///< columns of L as in BandMatrix, the diagonal inverted
};

}  // namespace struna::fem
