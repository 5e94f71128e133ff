#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/harmonic.hpp"
#include "fem/model.hpp"

namespace struna::fem {

/// A linear body in time as a sum of first-order poles, the form in which it is stepped exactly:
///   z_k' = mu_k z_k + b_k . p(t),   y = Re sum_k c_k z_k  (one pole of each conjugate pair, its c doubled; real poles as they are).
/// Viscous modes give one complex pole (or two real ones); a causal viscoelastic mode some real poles besides.
/// Inputs and outputs are modal: b has one column per generalised load, c one row per wanted displacement; the velocities
/// follow from mu_k c_k (and b . p where the residues do not cancel, which for displacements they do).
struct PoleSystem {
  Eigen::VectorXcd pole;     ///< mu [1/s], Re < 0 (or = 0 undamped)
  Eigen::VectorXi mode;      ///< the mode each pole belongs to
  Eigen::VectorXcd residue;  ///< r_k: mode's displacement q_m = Re sum_k z_k for unit modal load when b_k = r_k
  int modes = 0;
};

/// Poles of the modes of a body. viscous: q'' + (alpha + beta w^2) q' + w^2 q = p. structural: a causal
/// generalised Maxwell law fitted to E(f)(1 + i eta(f)) around each mode, so that the poles' response meets E(f_r) and
/// eta(f_r) at each resonance exactly and the law over the band as well as a causal law can.
PoleSystem pole_system(const Model& model, const Eigenmodes& modes, Damping damping, double band_hi_hz);

}  // namespace struna::fem
