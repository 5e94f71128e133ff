#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/band_cholesky.hpp"
#include "fem/harmonic_problem.hpp"

namespace struna::fem {

/// All modes over a problem's dof of (K1 + shift M) phi = mu M phi, mass-normalised, highest first.
struct ShiftedModes {
  double shift = 0.0;
  BandCholesky stiffness;  ///< K1 + shift M
  Eigen::ArrayXd eigenvalue;
  Eigen::MatrixXd shape;  ///< dof x modes
};

/// Shifted by clamped_eigenvalue(), which makes any body's stiffness definite. From the reciprocal problem:
/// the rounding is relative to the lowest modes, which make the response, where that of solve_eigenmodes() is
/// relative to the highest.
ShiftedModes shifted_modes(const HarmonicProblem& problem, const Body& body);

/// The harmonic response of a mesh as the sum over all of its modes. Both damping models scale K1 and M by
/// complex numbers, so the real modes of (K1, M) uncouple every line, whatever E(f) and eta(f) are, and a
/// line costs a division per mode. Nothing is left out: the result is that of the factorised dynamic
/// stiffness, to rounding.
///
/// Motions and forces of supports are split into the static part and what inertia adds (docs/harmonic.md), so
/// that no large terms cancel.
class ModalSum {
 public:
  /// `modes`: of the problem, or of one with the same dof of the same model.
  ModalSum(const ShiftedModes& modes, const HarmonicProblem& problem);

  /// Outputs over drive at one line. Not finite at a resonance without damping, where there is none.
  Eigen::VectorXcd response(const DynamicScales& scales) const;

 private:
  struct Output {
    bool at_support = false;
    /// H = s_k stiffness + tau mass + constant + modal part.
    double stiffness = 0.0;
    double mass = 0.0;
    double constant = 0.0;
  };

  double shift_;
  bool driven_at_support_;
  std::vector<Output> outputs_;
  Eigen::ArrayXd shifted_eigenvalue_;
  Eigen::MatrixXd constants_;  ///< outputs x modes: products of the weights of output and drive
};

}  // namespace struna::fem
