#pragma once

#include <Eigen/Core>
#include <complex>
#include <string>
#include <vector>

#include "ident/record.hpp"
#include "ident/window.hpp"

namespace struna::ident {

/// How records are cut into segments.
///
/// `automatic` window: Hann, unless the resolution is left to the program too and the excitation turns out to
/// pass over the lines one after the other (a sweep, a chirp, a burst): then the record is one rectangular
/// segment, which leaks only what is still moving at its end. With `impact`, rectangular. Resolution 0:
/// rectangular, one segment over the whole record; else segments of T/7.5, T the duration of all records
/// together (about 13 effective averages), but no longer than the shortest record or 100 s.
/// A Hann segment's length is reduced to one with no prime factor above 7; a rectangular one's is not, so
/// that whole periods of a periodic excitation stay whole.
struct WelchOptions {
  double resolution_hz = 0.0;  ///< line spacing 1/T of a segment; 0: chosen from the record's length
  double overlap = 2.0 / 3.0;  ///< of a segment, [0, 0.9]
  Window window = Window::automatic;
  double exponential_end = 0.01;  ///< exponential window: its value at the segment's end, in (0, 1)
  bool impact = false;            ///< a hit per record: one segment each, the record's whole length
};

/// Averaged one-sided spectral densities of one input and several outputs. A density's scale drops out of
/// transfer functions; it is kept physical [unit^2/Hz] so that amplitude ratios and noise floors can be
/// shown.
struct Spectra {
  Channel input;
  std::vector<Channel> outputs;
  Eigen::VectorXd frequency_hz;  ///< lines, 0 .. Nyquist
  Eigen::VectorXd input_auto;    ///< S_xx
  Eigen::MatrixXd output_auto;   ///< S_yy, lines x outputs
  Eigen::MatrixXcd cross;        ///< S_xy = conj(X) Y, lines x outputs
  double segments = 0.0;         ///< averaged, over all repeats
  double effective_averages =
      0.0;  ///< independent averages they are worth (Welch 1967, overlap correlation of the window)
  double resolution_hz = 0.0;
  double sample_interval = 0.0;  ///< [s]
  Window window = Window::hann;  ///< the one that was used, never automatic
  double exponential_decay =
      0.0;  ///< [1/s] of the exponential window, 0 without: to be taken out of every mode's damping
  std::vector<std::string> warnings;  ///< what a user should know: second hits, a response cut off
};

/// Welch's method over repeats of one setup, streaming (one-segment methods hold one record at a time). The
/// mean of each segment is taken out; of a hit, each channel's mean before it. Segments never span two
/// records. Throws Error when a record is shorter than a segment, repeats differ in sampling interval, an
/// option is out of range, a channel is named twice, or the input is at rest all the time.
Spectra welch_spectra(const std::vector<std::string>& files, const std::string& input,
                      const std::vector<std::string>& outputs, const WelchOptions& options,
                      const std::map<std::string, ChannelCorrection>& corrections = {});

/// The same for a record in memory.
Spectra welch_spectra(const Record& record, const std::string& input, const std::vector<std::string>& outputs,
                      const WelchOptions& options);

}  // namespace struna::ident
