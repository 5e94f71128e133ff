#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ident/record.hpp"

namespace struna::ident {

/// A record being read: blocks of rows (input first, then the outputs), and the sample interval [s], exact
/// once all rows are read.
struct Rows {
  std::function<long(Eigen::MatrixXd&, long)> read;
  std::function<double()> sample_interval;
};

/// One record of a setup, wherever it is.
struct Repeat {
  std::string name;
  double sample_interval = 0.0;  ///< from its first rows [s]
  long samples = 0;              ///< 0 where not counted
  std::function<Rows()> open;
  std::shared_ptr<std::vector<ChannelWatch>> watches;  ///< of a file read to its end; empty before

  double duration() const { return static_cast<double>(samples) * sample_interval; }
};

/// The records of one setup: the same input and outputs, repeated.
struct Repeats {
  std::vector<Channel> channels;  ///< the input, then the outputs
  std::vector<Repeat> records;
};

/// Opens files. Counting samples costs a scan of each. Throws Error without a record or output, when a
/// channel is named twice, or when the files measure different quantities.
Repeats open_repeats(const std::vector<std::string>& files, const std::string& input,
                     const std::vector<std::string>& outputs,
                     const std::map<std::string, ChannelCorrection>& corrections, bool count_samples);
/// The same for a record in memory, which must outlive the result and hold finite values.
Repeats open_repeats(const Record& record, const std::string& input, const std::vector<std::string>& outputs);

/// The same for several records in memory, which must outlive the result.
Repeats open_repeats(const std::vector<Record>& records, const std::string& input,
                     const std::vector<std::string>& outputs);

/// What a user should look at in the records that have been read to their end: channels that stand at a
/// limit, and an input that is a hammer's although no `impact` is told.
std::vector<std::string> record_warnings(const Repeats& repeats, bool impact);

/// Throws Error unless all records are sampled alike, to 1e-3.
void check_sampled_alike(const std::vector<Repeat>& records);

/// Segment that suits the records' duration, their samples counted [s]: T/7.5, T that of all together, at
/// most the shortest record or 100 s.
double automatic_segment(const std::vector<Repeat>& records);

/// A whole record, samples by channels; its samples must have been counted.
Eigen::MatrixXd read_whole(const Repeat& record, Rows& rows, long channels);

}  // namespace struna::ident
