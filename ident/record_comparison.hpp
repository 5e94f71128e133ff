#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ident/record.hpp"

namespace struna::ident {

/// Rms of a signal in half-octave bands, [edge_k, edge_k+1) with edge_k = lo 2^(k/2).
struct HalfOctaveLevels {
  Eigen::VectorXd edge_hz;  ///< one more than there are bands
  Eigen::VectorXd rms;      ///< per band, unit of the signal
  long bands() const { return rms.size(); }
};

/// Edges of the half-octave bands from `lo` to the last that ends at or below `hi` [Hz], within 1 % (so that
/// 20 to 900 Hz holds the band that ends at 905 Hz). Throws Error unless 0 < lo and one band fits.
Eigen::VectorXd half_octave_edges(double lo_hz, double hi_hz);

/// Levels of a one-sided density [unit^2/Hz] on evenly spaced lines; each line stands for the spacing around
/// it, and edges cut lines in parts. Parseval: with every line in one band, the signal's own rms. Throws
/// Error on fewer than two lines.
HalfOctaveLevels half_octave_levels(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& density,
                                    const Eigen::VectorXd& edge_hz);

/// A simulated signal beside the measured one.
struct SignalComparison {
  std::string name;
  Quantity quantity = Quantity::unknown;
  Eigen::VectorXd correlation;      ///< per interval; NaN where either is at rest
  double correlation_of_all = 0.0;  ///< over the common duration
  Eigen::VectorXd level_db;         ///< 20 lg(simulated/measured rms) per half-octave band
  HalfOctaveLevels measured;
  HalfOctaveLevels simulated;
};

struct RecordComparison {
  double interval = 0.0;  ///< of a correlation [s]
  double skipped = 0.0;   ///< at the start, left out of the levels and of the correlation of all [s]
  double motion_correlation = 0.0;  ///< of the first channel, the motion, over the common duration
  std::vector<SignalComparison> signals;
  std::vector<std::string> not_compared;  ///< at rest in either record
};

struct RecordComparisonOptions {
  double interval = 1.0;  ///< [s]
  double skip = 0.0;      ///< [s]
  double lo_hz = 20.0;
  double hi_hz = 900.0;
};

/// Throws Error where a record of `samples` at `sample_interval` [s] could not be compared with the measured
/// one: sampling intervals that differ by more than 1e-6, a common duration below an interval, options out of
/// range. To be asked before a long run.
void require_comparable(const Record& measured, double sample_interval, long samples,
                        const RecordComparisonOptions& options = {});

/// Compares channels of the same name, sample by sample from the first rows on: the simulation was driven by
/// the measured motion, so both tell of the same instants. Correlation is Pearson's, means taken out. Levels
/// are from Welch's densities (Hann). Of the first channel, the motion, only the correlation is told: where
/// it is not close to 1, the records are not of one motion and the rest means nothing. Throws
/// Error as require_comparable does, and on a motion that is not in the measured record.
RecordComparison compare_records(const Record& measured, const Record& simulated,
                                 const RecordComparisonOptions& options = {});

}  // namespace struna::ident
