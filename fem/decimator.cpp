#include "fem/decimator.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {

Eigen::VectorXd anti_alias_filter(int factor) {
  if (factor < 1)
    throw Error(fmt::format("anti_alias_filter: the factor must be at least 1, got {}", factor));
  if (factor == 1) return Eigen::VectorXd::Ones(1);
  constexpr double attenuation = 82.0;  // [dB], 2 below 1e-4 for the window's ripple
  const double beta = 0.1102 * (attenuation - 8.7);
  const double transition = 2.0 * std::numbers::pi * 0.2 / factor;  // 0.4 to 0.6 of the kept rate
  const long half = static_cast<long>(std::ceil(0.5 * (attenuation - 7.95) / (2.285 * transition)));
  Eigen::VectorXd tap(2 * half + 1);
  for (long k = -half; k <= half; ++k) {
    const double x = static_cast<double>(k) / factor;  // cut-off at half the kept rate
    const double sinc = k == 0 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
    const double at = static_cast<double>(k) / static_cast<double>(half);
    tap[k + half] = sinc * std::cyl_bessel_i(0.0, beta * std::sqrt(1.0 - at * at));
  }
  return tap / tap.sum();
}

Decimator::Decimator(int factor) : factor_(factor), tap_(anti_alias_filter(factor)) {
  half_ = tap_.size() / 2;
}

Eigen::VectorXd Decimator::at(long index) const {
  const long last = first_ + static_cast<long>(recent_.size()) - 1;
  const auto sample = [&](long i) { return recent_[static_cast<std::size_t>(i - first_)]; };
  if (index < 0) return 2.0 * sample(0) - sample(std::min(-index, last));
  if (index > last) return 2.0 * sample(last) - sample(std::max(2 * last - index, first_));
  return sample(index);
}

Eigen::VectorXd Decimator::filtered(long centre) const {
  Eigen::VectorXd sum = tap_[half_] * at(centre);
  for (long k = 1; k <= half_; ++k) sum += tap_[half_ + k] * (at(centre + k) + at(centre - k));
  return sum;
}

void Decimator::push(const Eigen::VectorXd& sample, std::vector<Eigen::VectorXd>& kept) {
  if (finished_) throw Error("Decimator::push: the stream has been finished");
  recent_.push_back(sample);
  const long last = first_ + static_cast<long>(recent_.size()) - 1;
  while (next_kept_ + half_ <= last) {
    kept.push_back(filtered(next_kept_));
    next_kept_ += factor_;
  }
  // The start is needed for reflection until the filter has left it.
  while (next_kept_ - half_ > first_ && next_kept_ >= half_ &&
         static_cast<long>(recent_.size()) > 2 * half_ + 1) {
    recent_.pop_front();
    ++first_;
  }
}

void Decimator::finish(std::vector<Eigen::VectorXd>& kept) {
  finished_ = true;
  const long last = first_ + static_cast<long>(recent_.size()) - 1;
  for (; next_kept_ <= last; next_kept_ += factor_) kept.push_back(filtered(next_kept_));
}

}  // namespace struna::fem
