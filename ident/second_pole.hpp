#pragma once

#include <Eigen/Core>
#include <limits>

#include "ident/pole_fit.hpp"

namespace struna::ident {

/// The lines around one pole, and what its fit left of them.
struct LinesOfPole {
  Eigen::VectorXcd g;             ///< its function, of height 1
  Eigen::VectorXcd height;        ///< of its share, per output
  Eigen::MatrixXd sigma;          ///< of real and imaginary part, lines x outputs
  Eigen::MatrixXcd residual;      ///< (data - fitted)/sigma, lines x outputs
  double line_correlation = 1.0;  ///< neighbouring lines that are worth one; counted up to 2.5
};

/// Of pole r of a fit, on its window's lines [first, last).
LinesOfPole lines_of_pole(const PoleFit& fit, long r, const TransferFunction& window, long first, long last,
                          fem::Damping damping);

/// The lines without the other poles and the residual terms, each output over its mean sigma, as
/// looks_double() asks for them.
Eigen::MatrixXcd alone(const LinesOfPole& lines);

struct SecondPole {
  bool noticed = false;  ///< the residual has what two poles leave to one
  bool hinted = false;   ///< the same with less certainty: one chance in 20
  /// Half-power bandwidths: two modes of equal height that far apart would be noticed, or hinted at, in 95 of
  /// 100 such measurements; NaN with fewer than eight lines.
  double resolves_from = std::numeric_limits<double>::quiet_NaN();
};

/// Does one pole stand for two, and from which distance on would it show? Two poles s bandwidths apart differ
/// from one share S g, to second order in s, by D g^2 + E g^3 with D = s (difference of their heights) and,
/// where they are equal, E = s^2 S. The residual's part in such shapes beside g and a trend, over its
/// variance, is chi-square distributed where there is one pole only; its own frequency and loss factor have
/// taken one complex number already. Degrees of freedom with K outputs:
///   g^2 and g^3                                  4 K - 2
///   g^2                                          2 K - 2
///   g^2, heights in phase and equal damping      K - 1
/// The variance: that of noise, or what the shapes leave where that is more, times the lines worth one
/// (2.5 at most, as windows and local models leave them).
/// Noticed: one of them beyond one chance in 2000, and 0.35 % of the share (with one output, where only the
/// second order shows, 0.5 %). Hinted: beyond one chance in 20 in the last of them (one output: the first).
///
/// Power: noncentral chi-square, whose root is about normal, for a pair whose heights over the outputs
/// agree by a quarter (modal assurance; 60 degrees apart), their difference turned evenly over the outputs,
/// less what the pole's own frequency and loss factor take up.
SecondPole second_pole(const LinesOfPole& lines);

/// Exceeded with the probability that a normal variable exceeds `deviation` (Wilson & Hilferty, Proc. Natl.
/// Acad. Sci. 17 (1931) 684).
double chi_square_quantile(double freedom, double deviation);

/// Noncentrality from which on chi-square of `freedom` degrees exceeds `threshold` with probability 0.95.
double noticed_noncentrality(double threshold, double freedom);

}  // namespace struna::ident
