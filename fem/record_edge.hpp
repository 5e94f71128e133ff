#pragma once

#include <Eigen/Core>
#include <optional>

namespace struna::fem {

/// The start of a record that was brought to its sampling rate by a resampling filter with zeros in front of
/// its first sample: the samples within the filter's reach hold a part of a jump that the support never made
/// (the first one is half of what it should be).
struct RecordEdge {
  int factor = 1;            ///< the record was resampled by 1:factor
  Eigen::VectorXd repaired;  ///< the first samples as they would be without the edge
  double uncertainty = 0.0;  ///< largest standard deviation of them [m]
};

/// Looks for such an edge and takes it out. The motion is taken as a Gaussian process with the record's own
/// spectrum (Welch's, noise floor apart), the first samples as its resampled values; the factor is the most
/// likely one, the repaired samples are the conditional mean (Rasmussen & Williams, Gaussian Processes for
/// Machine Learning, eqs. 2.23-2.30). Filters that are tried: windowed sinc with a reach of 10 samples,
/// Kaiser (beta 5) or Hamming, the defaults of the common resample and decimate functions. None where the
/// record starts smoothly, where no such filter explains it (chi-square), or below 512 samples.
std::optional<RecordEdge> find_resampling_edge(const Eigen::VectorXd& samples, double sample_interval);

}  // namespace struna::fem
