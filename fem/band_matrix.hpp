#pragma once

#include <Eigen/Core>
#include <array>
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
/// A x for an x of few entries that are not zero: takes only their columns.
Eigen::VectorXd multiply_sparse(const BandMatrix& a, const Eigen::VectorXd& x);

/// The rows and columns `dof` (increasing) of A.
BandMatrix submatrix(const BandMatrix& a, const std::vector<int>& dof);

/// L D L^T of complex symmetric (not Hermitian) band matrices, without pivoting: sound for the damped dynamic
/// stiffness, whose imaginary part is definite (Higham, Accuracy and Stability, 2nd ed., problem 10.8).
/// Without damping a leading block can be near-singular; solve() then refines once, and a pivot of zero is
/// reported.
///
/// Works on `lanes` frequencies at a time, 1 or 4. With four they are the innermost index in memory, and the
/// loops over them are what the compiler turns into vector instructions on any machine; a single frequency
/// runs its vector instructions down the columns of the band. Real and imaginary parts are kept apart for the
/// same reason.
template <int lanes>
class ComplexBandSolver {
 public:
  using Scales = std::array<std::complex<double>, lanes>;
  using Lanes = Eigen::Array<double, lanes, Eigen::Dynamic, lanes == 1 ? Eigen::RowMajor : Eigen::ColMajor>;
  /// A vector per lane.
  struct Vectors {
    Lanes re;
    Lanes im;
  };

  /// K and M over the same dof, of one size and bandwidth, are kept by reference: they must outlive the
  /// solver.
  ComplexBandSolver(const BandMatrix& stiffness, const BandMatrix& mass);

  /// Factorises s_k K + s_m M in each lane. Returns the first lane with a pivot of zero (an undamped system
  /// exactly at a resonance), or -1.
  int factorise(const Scales& stiffness_scale, const Scales& mass_scale);
  /// Solves in place, with one step of iterative refinement when `refine`.
  void solve(Vectors& b, bool refine = false) const;

 private:
  void substitute(Vectors& b) const;
  /// b - (s_k K + s_m M) x.
  Vectors residual(const Vectors& b, const Vectors& x) const;

  const BandMatrix& stiffness_;
  const BandMatrix& mass_;
  Scales stiffness_scale_{};
  Scales mass_scale_{};
  Vectors factor_;   ///< L below the diagonal; column (j * (half bandwidth + 1) + k) is entry (j + k, j)
  Vectors inverse_;  ///< 1/D
};

extern template class ComplexBandSolver<1>;
extern template class ComplexBandSolver<4>;

}  // namespace struna::fem
