#pragma once

#include <Eigen/Core>
#include <vector>

namespace struna::ident {

/// What a local model takes H to be about a line.
enum class LocalForm {
  rational,   ///< N(r)/D(r), D common to all outputs: a resonance may be narrower than the window
  polynomial  ///< N(r)
};

struct LocalModelOptions {
  double line_spacing_hz = 0.0;  ///< spacing of the lines, and width of a block of sums
  long reach = 2;                ///< line spacings either side that a window holds besides the line's own
  long stride = 1;               ///< every which line is estimated
  LocalForm form = LocalForm::rational;
};

/// Transform of one record, unwindowed: X_k = sqrt(dt/N) sum_n x_n exp(-2 pi i k n/N), so that noise has the
/// same power in records of any length.
struct RecordSpectrum {
  double line_spacing_hz = 0.0;  ///< 1/(N dt)
  Eigen::MatrixXcd lines;        ///< k = 0 .. at most N/2, by channels: the input, then the outputs
};

/// Transfer functions without leakage, with their noise.
struct LocalModel {
  Eigen::VectorXd frequency_hz;
  Eigen::MatrixXcd value;       ///< H, lines x outputs
  Eigen::MatrixXd sigma;        ///< standard deviation of H's real and of its imaginary part, lines x outputs
  Eigen::MatrixXd coherence;    ///< |H|^2 S_xx/(|H|^2 S_xx + S_nn), lines x outputs
  Eigen::VectorXd input_power;  ///< mean |X|^2 in the window
  Eigen::MatrixXd noise_power;  ///< mean |V|^2 in the window, lines x outputs
};

/// Local rational or local polynomial estimate from all records of a setup, lines up to `highest_hz`.
///
/// In a window of lines about f, with r = (f_k - f)/half width,
///   D(r) Y_o(k) = N_o(r) X(k) + T_o(r) + D(r) V_o(k),  N_o, T_o of degree 2, D = 1 + d_1 r + d_2 r^2,
/// where T stands for what the ends of the record leak: it is as smooth as H (of the record's own; N and D
/// are common to all records). H_o(f) = N_o(0). Pintelon & Schoukens, System Identification, 2nd ed., ch. 7
/// (local polynomial method, D = 1); McKelvey & Guerin, IFAC SYSID 2012 (local rational method). D is found
/// from all outputs together, each weighted by its own noise, and freed of the bias that noise in the
/// regressors r Y brings (limited-information form, Fuller, Econometrica 45 (1977) 939), with a prior on d,
/// which rules where noise hides any pole. Sums over windows are shifted and added from blocks of one line
/// spacing, so the cost hardly depends on the window. See docs/local_model.md.
///
/// Lines at whose window the input has no power, or cannot be told from leakage, are left out. Throws Error
/// for a spacing that is not positive, a reach or stride below 1, records without output or of different
/// channels, and for a record with fewer lines in a window than its own unknowns need.
LocalModel local_model(const std::vector<RecordSpectrum>& records, double highest_hz,
                       const LocalModelOptions& options);

}  // namespace struna::ident
