#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "ident/record.hpp"

namespace struna::ident {

enum class Window { hann, rectangular, exponential };

struct WelchOptions {
  double resolution_hz = 0.0;  ///< line spacing 1/T of a segment; 0: chosen from the record's length
  double overlap = 0.5;        ///< of a segment, [0, 0.9]
  Window window = Window::hann;
  double exponential_end = 0.01;  ///< exponential window: its value at the segment's end, in (0, 1)
  bool impact = false;         ///< a hit per record: one segment each, the record's whole length
};

/// Averaged one-sided spectral densities of one input and several outputs. A density's scale drops out of transfer functions; it
/// is kept physical [unit^2/Hz] so that amplitude ratios and noise floors can be shown.
struct Spectra {
  Channel input;
  std::vector<Channel> outputs;
  Eigen::VectorXd frequency_hz;     ///< lines, 0 .. Nyquist
  Eigen::VectorXd input_auto;       ///< S_xx
  Eigen::MatrixXd output_auto;      ///< S_yy, lines x outputs
  Eigen::MatrixXcd cross;           ///< S_xy = conj(X) Y, lines x outputs
  double segments = 0.0;            ///< averaged, over all repeats
  double effective_averages = 0.0;  ///< independent averages they are worth (Welch 1967, overlap correlation of the window)
  double resolution_hz = 0.0;
  double exponential_decay = 0.0;   ///< [1/s] of the exponential window, 0 without: to be taken out of every mode's damping
};

/// Welch's method over repeats of one setup, streaming. Throws Error when a record is shorter than a segment, or
/// repeats differ in sampling interval.
Spectra welch_spectra(const std::vector<std::string>& files, const std::string& input,
                      const std::vector<std::string>& outputs, const WelchOptions& options,
                      const std::map<std::string, ChannelCorrection>& corrections = {});

/// The same for a record in memory.
Spectra welch_spectra(const Record& record, const std::string& input, const std::vector<std::string>& outputs,
                      const WelchOptions& options);

}  // namespace struna::ident
