#include "ident/channel_watch.hpp"

#include <algorithm>
#include <cmath>

namespace struna::ident {

void ChannelWatch::Top::add(double x) {
  if (x == value) {
    ++count;
  } else if (x > value) {
    next = value;
    next_count = count;
    value = x;
    count = 1;
  } else if (x == next) {
    ++next_count;
  } else if (x > next) {
    next = x;
    next_count = 1;
  }
}

void ChannelWatch::add(const Eigen::Ref<const Eigen::VectorXd>& samples) {
  if (samples.size() == 0) return;
  if (count_ == 0) first_ = samples[0];
  count_ += samples.size();
  const Eigen::ArrayXd x = samples.array() - first_;
  const Eigen::ArrayXd square = x.square();
  sum_ += Eigen::Array4d(x.sum(), square.sum(), (x * square).sum(), square.square().sum());
  // Most blocks of a long record have nothing near the extremes.
  if (samples.maxCoeff() >= upper_.next)
    for (const double value : samples) upper_.add(value);
  if (-samples.minCoeff() >= lower_.next)
    for (const double value : samples) lower_.add(-value);
}

double ChannelWatch::variance() const {
  const double m = mean();
  return std::max(0.0, sum_[1] / static_cast<double>(count_) - m * m);
}

double ChannelWatch::third_moment() const {
  const double m = mean();
  const Eigen::Array4d moment = sum_ / static_cast<double>(count_);
  return moment[2] - 3.0 * m * moment[1] + 2.0 * m * m * m;
}

double ChannelWatch::fourth_moment() const {
  const double m = mean();
  const Eigen::Array4d moment = sum_ / static_cast<double>(count_);
  return moment[3] - 4.0 * m * moment[2] + 6.0 * m * m * moment[1] - 3.0 * m * m * m * m;
}

double ChannelWatch::active_share() const {
  if (count_ == 0 || variance() == 0.0) return 0.0;
  return variance() * variance() / fourth_moment();
}

double ChannelWatch::one_sidedness() const {
  if (count_ == 0 || variance() == 0.0) return 0.0;
  return third_moment() * third_moment() / (variance() * fourth_moment());
}

long ChannelWatch::at_limit(const Top& top) const {
  // A sine in coarse steps stands at its top step up to 2.4 times as often as at the next: sqrt(1) to
  // sqrt(2) - 1. Noise stands there less often than at the next.
  constexpr long fewest = 5;
  constexpr long times_next = 5;
  if (top.count < fewest || top.count < times_next * top.next_count || 2 * top.count >= count_) return 0;
  const double centre = (&top == &upper_ ? 1.0 : -1.0) * (first_ + mean());
  return top.value - centre > std::sqrt(variance()) ? top.count : 0;
}

}  // namespace struna::ident
