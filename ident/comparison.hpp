#pragma once

#include <string>
#include <vector>

#include "ident/transfer_function.hpp"

namespace struna::ident {

struct PeakDifference {
  double measured_hz = 0.0;
  double predicted_hz = 0.0;  ///< NaN when the prediction has no peak at all
  double amplitude_db = 0.0;  ///< 20 lg(|H_p|/|H_m|) at their peaks
};
struct OutputComparison {
  std::string output;
  FrfKind kind = FrfKind::unknown;  ///< in which they were compared: the measured one's
  long lines = 0;
  double frac = 0.0;                    ///< |H_p^H H_m|^2/((H_m^H H_m)(H_p^H H_p)), Heylen, Lammens & Sas
  double log_magnitude_error_db = 0.0;  ///< rms of 20 lg|H_p/H_m| over the band
  double mean_db = 0.0;                 ///< mean of the same: a level offset
  double largest_db = 0.0;              ///< largest magnitude of the same
  double noise_share = 0.0;   ///< of the measured sum of squares, by its sigma: 1 - noise_share is about the
                              ///< FRAC that a perfect prediction reaches
  double measured_rms = 0.0;  ///< magnitude over the band [unit of the form]
  std::vector<PeakDifference>
      peaks;  ///< peaks of the measured one, each with the predicted one nearest to it
};
struct Comparison {
  double lo_hz = 0.0;
  double hi_hz = 0.0;
  std::vector<OutputComparison> outputs;
  std::vector<std::string> not_compared;  ///< measured outputs that the prediction does not have
};

/// Compares outputs of the same name over the band that both have, on the measured lines (prediction
/// interpolated in magnitude and phase between its neighbouring lines where they differ), in the measured
/// one's form: a prediction whose motion quantity is another is converted. 0, 0: the whole common band. A
/// peak is a local maximum of |H| that stands above the higher of the two saddles beside it by 6 dB and,
/// where measured, by five times the standard deviations of both lines together (without sigma in the file:
/// those that the scatter from line to line tells). It is set against the nearest predicted one of half a
/// decibel and more. A line where either function is exactly zero has no logarithm and is left out of the dB
/// figures; what is not defined at all (a function that vanishes) is NaN, an empty field in the file. Throws
/// Error when no output or line is common, or the forms cannot be converted.
Comparison compare(const TransferFunction& measured, const TransferFunction& predicted, double lo_hz = 0.0,
                   double hi_hz = 0.0);

/// comparison.csv: output,frac [-],log_magnitude_error [dB],mean_difference [dB],largest_difference
/// [dB],peaks [-], peak_frequency_error [-],peak_amplitude_error [dB],lines [-],band_lo [Hz],band_hi
/// [Hz],form; peak errors are rms over the peaks (empty without any). Atomic.
void write_comparison(const Comparison& comparison, const std::string& file);

/// Whether the output can be compared at all: FRAC and level error are numbers.
bool is_defined(const OutputComparison& output);

/// Mean of the level errors over the outputs that are defined [dB]; NaN without any.
double mean_level_error_db(const Comparison& comparison);

/// rms over the peaks of f_p/f_m - 1 and of the amplitude differences [dB]; NaN without peaks.
double peak_frequency_error(const OutputComparison& output);
double peak_amplitude_error_db(const OutputComparison& output);

}  // namespace struna::ident
