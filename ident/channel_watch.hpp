#pragma once

#include <Eigen/Core>
#include <limits>

namespace struna::ident {

/// Watches the samples of a channel go by, block by block, for what makes a measurement useless: clipping,
/// and an input that acts in a small part of the record only. Memory and time do not depend on the record.
class ChannelWatch {
 public:
  void add(const Eigen::Ref<const Eigen::VectorXd>& samples);

  /// How often the largest (the smallest) value stands in the record where that is far more often than the
  /// next one to it, as behind an amplifier or a converter at its limit; 0 for a sound channel. A value at
  /// which the channel rests is no limit: one that is within a standard deviation of the mean, or half of the
  /// samples.
  long at_upper_limit() const { return at_limit(upper_); }
  long at_lower_limit() const { return at_limit(lower_); }
  double upper() const { return upper_.value; }
  double lower() const { return -lower_.value; }

  /// (sum x^2)^2 / (N sum x^4) of the samples without their mean: the share of the record in which a signal
  /// of one level acts. Noise has 1/3, a sine 2/3, a half-sine pulse 2/3 of the share that it takes. 0 for a
  /// channel at rest.
  double active_share() const;

  /// (sum x^3)^2 / (sum x^2 sum x^4), from 0 (both signs alike) to 1 (pulses of one sign); 0 at rest.
  double one_sidedness() const;

 private:
  /// The two largest values so far and how often they were met.
  struct Top {
    double value = -std::numeric_limits<double>::infinity();
    double next = -std::numeric_limits<double>::infinity();
    long count = 0;
    long next_count = 0;
    void add(double x);
  };

  long at_limit(const Top& top) const;
  double mean() const { return sum_[0] / static_cast<double>(count_); }
  double variance() const;
  double third_moment() const;  ///< central, as the next one
  double fourth_moment() const;

  Top upper_;
  Top lower_;  ///< of the samples with their sign reversed
  long count_ = 0;
  double first_ = 0.0;
  Eigen::Array4d sum_ = Eigen::Array4d::Zero();  ///< of x - first to the powers 1 to 4
};

}  // namespace struna::ident
