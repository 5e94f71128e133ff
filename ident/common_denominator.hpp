#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/resonance.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident {

/// A pole of a model with a common denominator, and its share in each output.
struct DenominatorPole {
  Pole pole;
  Eigen::VectorXcd modal_constant;  ///< C_k, as in Mode
  double gain = 0.0;                ///< what its share takes out of the sum of squares over sigma
};

/// All outputs over a band by one rational function of each order 1 ... max_order: H_k = N_k/D by least
/// squares of N_k - D H_k over sigma_k, linear in the coefficients (Levy, IRE Trans. AC-4 (1959) 37; with one
/// denominator for all functions the least squares complex frequency domain estimator: Van der Auweraer et
/// al., J. Dyn. Syst. Meas. Control 123 (2001) 651). Coefficients are complex, as only positive frequencies
/// are looked at: a hysteretic pole has no conjugate partner, and each mode costs one order.
///
/// The variable is x = f^2 for structural, f for viscous damping, so a sum of hysteretic modes beside
/// residual terms b + c x is met exactly at order = modes (viscous: but for the modes' mirror images at
/// negative frequency). It goes to the unit circle by z = (u - i beta)/(u + i beta), u = -1 ... 1 over the
/// band, which leaves rational functions rational: powers of z are well conditioned, positive damping is |z|
/// < 1, and all sums are Toeplitz. Lines are weighted by dtheta/du, as if even on the circle. With D(0) = 1
/// the zeros that only noise asks for fall outside the circle, as those of a backward predictor do (Kumaresan
/// & Tufts, IEEE Trans. ASSP-30 (1982) 833; Cauberghe et al., Mech. Syst. Signal Process. 19 (2005) 989):
/// negative damping, left out. What remains is nearly all modes.
///
/// Numerators are eliminated by one Cholesky factor per output whose leading parts serve every order, so all
/// orders come from one pass over the lines: a few operations per line, output and order.
///
/// Returned: element n - 1 has the poles of order n within the band, loss factor in (0, 1), ascending in
/// frequency. Damping is biased upwards or downwards where noise is large; it is a start, not an estimate.
/// `tf` in circle form with sigma, at least max_order + 3 lines; max_order 1 to 60; throws Error otherwise.
std::vector<std::vector<DenominatorPole>> fit_common_denominator(const TransferFunction& tf,
                                                                 fem::Damping damping, int max_order);

}  // namespace struna::ident
