#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

namespace struna::fem {

/// Linear-phase low-pass of a Kaiser window (Kaiser & Schafer, IEEE Trans. ASSP 28 (1980) 105) for keeping
/// every `factor`-th sample: within 1e-4 of unity up to 0.4 of the kept rate, below 1e-4 from 0.6 of it, so
/// that what folds lies above 0.4 of it. Odd length, symmetric, sum 1. {1} for a factor of 1.
Eigen::VectorXd anti_alias_filter(int factor);

/// Filters and keeps every `factor`-th of a stream of sample vectors, without delay: kept sample n belongs to
/// the time of sample n factor. Beyond its ends the stream is continued by point reflection. Holds one filter
/// length of samples.
class Decimator {
 public:
  explicit Decimator(int factor);
  /// Takes the next sample; appends what can be kept by now to `kept`.
  void push(const Eigen::VectorXd& sample, std::vector<Eigen::VectorXd>& kept);
  /// Ends the stream: appends the rest.
  void finish(std::vector<Eigen::VectorXd>& kept);

 private:
  Eigen::VectorXd at(long index) const;
  Eigen::VectorXd filtered(long centre) const;

  long factor_;
  long half_;  ///< taps on either side
  Eigen::VectorXd tap_;
  std::deque<Eigen::VectorXd> recent_;  ///< samples first_ .. first_ + size - 1
  long first_ = 0;
  long next_kept_ = 0;  ///< index of the next sample to keep
  bool finished_ = false;
};

}  // namespace struna::fem
