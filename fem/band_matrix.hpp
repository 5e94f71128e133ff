#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace struna::fem {

/// Symmetric band matrix, lower half stored by columns: lower(k, j) = a(j + k, j), k = 0..half_bandwidth.
/// Beams in node order have half bandwidth 11.
struct BandMatrix {
  Eigen::MatrixXd lower;  ///< (half_bandwidth + 1) x n

  int size() const { return static_cast<int>(lower.cols()); }
  int half_bandwidth() const { return static_cast<int>(lower.rows()) - 1; }
  double at(int i, int j) const;
  Eigen::MatrixXd dense() const;
};

/// y = A x for each column.
Eigen::MatrixXd multiply(const BandMatrix& a, const Eigen::MatrixXd& x);

/// L D L^T of a complex symmetric (not Hermitian) band matrix, without pivoting: sound for the damped dynamic stiffness,
/// whose imaginary part is definite. Reuses its storage from one frequency to the next.
class ComplexBandSolver {
 public:
  /// Factorises s_k K + s_m M over the dof `free` (increasing). K and M of one size and bandwidth.
  /// Returns false on a zero pivot (an undamped system exactly at a resonance).
  bool factorise(const BandMatrix& stiffness, std::complex<double> stiffness_scale, const BandMatrix& mass,
                 std::complex<double> mass_scale, const std::vector<int>& free);
  /// Solves in place; rows of `b` follow `free`.
  void solve(Eigen::MatrixXcd& b) const;

 private:
  Eigen::MatrixXcd lower_;
};

}  // namespace struna::fem
