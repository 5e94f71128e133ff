#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "ident/resonance.hpp"
#include "ident/transfer_function.hpp"

/// The columns that a fit of common poles is made of. Columns are real: the real parts of all lines, then the
/// imaginary parts.
namespace struna::ident {

/// What stands for everything outside the poles fitted; complex coefficients per output.
enum class ResidualTerms {
  constant,  ///< 1
  linear,    ///< 1, omega^2
  band       ///< 1/omega^2, 1, omega^2 (mobility: 1/omega, 1, omega): modes below, feedthrough, modes above
};
long residual_count(ResidualTerms terms);

/// Span of the residual terms over the lines' omega, as Legendre polynomials over the band: well conditioned.
/// lines x residual_count, real: each stands for the real and for the imaginary part.
Eigen::MatrixXd residual_shapes(const Eigen::VectorXd& omega, FrfKind kind, ResidualTerms terms);

/// d p_r / d(ln f, ln eta) in the sense that d g = g^2 * slope: structural -d lambda(1 + i eta), viscous d p.
std::array<std::complex<double>, 2> pole_slopes(const Pole& pole, fem::Damping damping);

/// The same for g of height one (times pole_scale), of which a mode with constant C has C/pole_scale: what a
/// step of ln f and of ln eta makes of the coefficient of g^2.
std::array<std::complex<double>, 2> scaled_slopes(const Pole& pole, fem::Damping damping);

/// Columns of Re c and Im c of a pole's share c g (g of height one; viscous, with `mirror`, also its mirror
/// image at negative frequency) into columns first, first + 1, and the same with g^2 in place of g, which
/// serve every derivative, into columns square, square + 1.
void fill_pole_columns(const Pole& pole, const Eigen::VectorXd& omega, fem::Damping damping, bool mirror,
                       long first, long square, Eigen::MatrixXd& columns);

/// Takes loss factors that lie on a bound of `moved`, and would be pushed beyond it, out of a step in (ln f,
/// ln eta, …): a pole that stands for far neighbours may end there, and would keep the others from settling.
void hold_at_bounds(const std::vector<Pole>& poles, Eigen::VectorXd& gradient, Eigen::MatrixXd& hessian);

/// Poles moved by `delta` (ln f, ln eta of each), the whole step shortened so that none goes farther than a
/// bandwidth or changes its damping by more than a factor e; `share` receives what was taken of it.
std::vector<Pole> moved(const std::vector<Pole>& poles, const Eigen::VectorXd& delta,
                        double* share = nullptr);

/// Largest move of any pole, in bandwidths and parts of its damping.
double size_of(const Eigen::VectorXd& delta, const std::vector<Pole>& poles);

/// Up to three lines apart, as far as a Hann window reaches: neighbouring lines that are worth one,
/// 1 + 2 sum of the autocorrelation; what is within its own scatter counts as none.
double line_correlation(const Eigen::MatrixXcd& residual);

/// Correlation of the outputs' noise, outputs x outputs, from the residual (lines x outputs): rho_kl =
/// sum r_k conj(r_l)/..., zero where it is within its own scatter (three standard errors). Noise on the input
/// is shared by all outputs, and so is what one amplifier or ground loop brings.
Eigen::MatrixXcd shared_noise(const Eigen::MatrixXcd& residual, double line_correlation);

/// Covariance of the sum over outputs of Re(J_k^H r_k) for residuals so correlated: sum of Re(rho_kl J_k^H
/// J_l).
Eigen::MatrixXd score_covariance_of(const std::vector<Eigen::MatrixXcd>& derivative,
                                    const Eigen::MatrixXcd& shared);

}  // namespace struna::ident
