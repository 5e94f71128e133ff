#pragma once

#include <Eigen/Core>

#include "fem/model.hpp"

namespace struna::fem {

/// K1 phi = lambda M phi over the free dof, ascending: lambda = omega^2/E [1/(Pa s^2)]; shapes
/// mass-normalised, rows over all dof (zero at held ones).
struct Eigenmodes {
  Eigen::VectorXd eigenvalue;
  Eigen::MatrixXd shape;  ///< dof x modes
};

/// lambda of the first bending mode of the straight body clamped at both ends: the scale that eigenvalues of
/// this body are judged against.
double clamped_eigenvalue(const Body& body);

/// The lowest `count` modes (all of them when 0 or too many). All, or many of a small model: a dense solver;
/// few of a fine mesh: subspace iteration on the band matrices.
Eigenmodes solve_eigenmodes(const Model& model, int count = 0);

/// Whether a mode is a rigid motion of a body that is not held: its eigenvalue vanishes against
/// clamped_eigenvalue(). The softest elastic mode, a cantilever's first, is at 2.5e-2 of it; the solvers'
/// rounding reaches the limit, 1e-4, beyond some 400 elements only.
bool is_rigid(const Body& body, double eigenvalue);

/// How many of ascending eigenvalues, the first ones, are rigid.
long rigid_modes(const Body& body, const Eigen::VectorXd& eigenvalue);

/// f with (2 pi f)^2 = E(f) lambda [Hz]: fixed point, unique while E rises slower than f^2.
double natural_frequency_hz(double eigenvalue, const FrequencyLaw& youngs_modulus);

/// natural_frequency_hz() of each of a body's eigenvalues; 0 for rigid ones.
Eigen::VectorXd natural_frequencies_hz(const Body& body, const Eigen::VectorXd& eigenvalue);

/// E = (2 pi f)^2/lambda [Pa]: the modulus that puts a mode at f.
double modulus_from_frequency(double f_hz, double eigenvalue);

}  // namespace struna::fem
