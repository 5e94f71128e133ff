#pragma once

#include <vector>

#include "ident/pole_fit.hpp"
#include "ident/references.hpp"

namespace struna::ident {

/// A fit in which every mode has one shape u over the outputs, whatever reference excites it, and one
/// participation v in each reference: its constants C_oj = u_o v_j are of rank one in outputs x references.
struct RankOneFit : PoleFit {
  Eigen::MatrixXcd participation;  ///< references x poles, the largest of each pole 1
  Eigen::VectorXd rank_excess;     ///< per pole: what freeing its constants takes from chi_square, its
                                   ///< expectation 2 (outputs - 1)(references - 1) for noise alone
};

/// Common poles of all outputs and references, constants of rank one. Weighted least squares as in fit_poles:
/// the shapes u and the residual terms of each column, in which the model is linear, are eliminated exactly;
/// Levenberg-Marquardt moves ln f, ln eta and v. `start_participation`: references x poles. One pole always
/// has rank one; two of one frequency have rank two, so their distance shows to first order here, where free
/// constants show it to second order only. `tf` in circle form, each column with sigma. Throws Error as
/// fit_poles does.
RankOneFit fit_rank_one(const TransferFunction& tf, const References& references,
                        const std::vector<Pole>& start, const Eigen::MatrixXcd& start_participation,
                        const PoleFitOptions& options);

/// Two poles of rank one in place of one: what the function's expansion C g + D g^2 about it says, of two
/// shares u_i v_i^T (g + s_i g^2) with C = sum u_i v_i^T, D = sum s_i u_i v_i^T: the eigenvalues s_i of the
/// pencil (D, C) in the plane of C's (or, where C is of rank one, of both's) first two singular vectors.
struct PolePair {
  std::vector<Pole> poles;         ///< two
  Eigen::MatrixXcd participation;  ///< references x 2
};
/// `poles`: all of the window's, of which `which` is to be split.
PolePair split_pole(const TransferFunction& tf, const References& references, const std::vector<Pole>& poles,
                    long which, const PoleFitOptions& options);

/// Per pole the participation that its free constants (poles x columns) suggest: references x poles.
Eigen::MatrixXcd dominant_participation(const References& references, const Eigen::MatrixXcd& constant,
                                        const Eigen::MatrixXd& sigma);

}  // namespace struna::ident
