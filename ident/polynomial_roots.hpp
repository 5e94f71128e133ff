#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace struna::ident {

/// Roots of y^n + c_1 y^(n-1) + ... + c_n, c = (c_1 ... c_n), n of them in no order, from `start` (as many as
/// the roots, all different; near them, a few sweeps suffice): simultaneous Newton steps that keep off each
/// other's roots (Ehrlich, Comm. ACM 10 (1967) 107; Aberth, Math. Comp. 27 (1973) 339), n^2 operations a
/// sweep. Where they do not settle: eigenvalues of the companion matrix. Accurate to the conditioning of the
/// roots; of a double root half the digits. Empty for n = 0 and where a
/// coefficient is not finite; throws Error for another number of starts.
std::vector<std::complex<double>> polynomial_roots(const Eigen::VectorXcd& c,
                                                   std::vector<std::complex<double>> start);

}  // namespace struna::ident
