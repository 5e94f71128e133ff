#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ident/channel_watch.hpp"
#include "ident/units.hpp"

namespace struna::ident {

/// Corrections applied to a column before use: value = sign * sensitivity * raw, at time + delay.
struct ChannelCorrection {
  double sensitivity = 1.0;  ///< SI per raw unit, or a plain factor when the header has a unit
  double sign = 1.0;         ///< +1 or -1
  double delay =
      0.0;  ///< [s] by which the channel lags the others; taken out exactly, in the spectra, as a phase
  std::string unit;  ///< replaces the header's unit when not empty
};

struct Channel {
  std::string name;
  Quantity quantity = Quantity::unknown;
  double delay = 0.0;  ///< [s]
};

/// Uniformly sampled channels in SI units.
struct Record {
  double start = 0.0;            ///< [s]
  double sample_interval = 0.0;  ///< [s]
  std::vector<Channel> channels;
  Eigen::MatrixXd samples;  ///< samples x channels
};

/// Streams the wanted columns of a records CSV in blocks; memory does not grow with the file. Columns that
/// are not wanted are not looked into.
///
/// Every fault is an Error with file and line: missing column (tells those there are), unknown unit, text or
/// an empty field where a number belongs, NaN or infinity, a row with too few or too many fields, an empty or
/// one-row file, a correction for a column that is not read, time that does not increase or is not uniform:
/// each step must be within 1 % of the mean one so far, plus what the written digits of the time column (or
/// single precision behind them) cannot resolve, which is never taken as more than three quarters of a step,
/// so that a missing row shows.
class RecordReader {
 public:
  RecordReader(const std::string& file, const std::vector<std::string>& columns,
               const std::map<std::string, ChannelCorrection>& corrections = {});
  ~RecordReader();
  RecordReader(RecordReader&&) noexcept;

  const std::vector<Channel>& channels() const;
  /// Fills `block` (at most `rows` x columns, SI, corrected); returns the number of rows, 0 at the end of the
  /// file.
  long read(Eigen::MatrixXd& block, long rows);
  /// Sampling interval [s]; known after the first read, refined to the mean over all rows at the end.
  double sample_interval() const;
  /// Time of the first row [s]; known after the first read.
  double start() const;
  /// What the samples read so far tell of each channel.
  const std::vector<ChannelWatch>& watches() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What a user should look at before the record is believed, a line each with the file's name in front:
/// channels that stand at a limit.
std::vector<std::string> record_warnings(const std::string& file, const std::vector<Channel>& channels,
                                         const std::vector<ChannelWatch>& watches);

/// The number of data rows: a quick scan for line ends.
long count_rows(const std::string& file);

/// A whole record in memory.
Record read_record(const std::string& file, const std::vector<std::string>& columns,
                   const std::map<std::string, ChannelCorrection>& corrections = {});

/// Writes `time [s]` and the channels with their SI units, nine digits; atomic (see atomic_file.hpp). Throws
/// Error for a channel of unknown quantity, or with a delay (the file could not tell it).
void write_record(const Record& record, const std::string& file);

}  // namespace struna::ident
