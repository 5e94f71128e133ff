#include "ident/noise_floor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace struna::ident {
namespace {

constexpr long half_median = 20;        // lines either side that the median of differences looks at
constexpr long half_mean = 4;           // lines either side that a given variance is averaged over
constexpr double least_sigma = 1e-100;  // of a function that vanishes: its square must not

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Running median at every `half_median`-th line and linear between: the noise floor is smooth.
Eigen::VectorXd running_median(const Eigen::VectorXd& values) {
  const long n = values.size();
  std::vector<double> at, knot;
  for (long centre = 0;; centre = std::min(centre + half_median, n - 1)) {
    const long first = std::max(0L, centre - half_median), last = std::min(n - 1, centre + half_median);
    at.push_back(static_cast<double>(centre));
    knot.push_back(median({values.data() + first, values.data() + last + 1}));
    if (centre == n - 1) break;
  }
  Eigen::VectorXd result(n);
  for (long i = 0, k = 0; i < n; ++i) {
    while (k + 2 < static_cast<long>(at.size()) && static_cast<double>(i) > at[k + 1]) ++k;
    if (at.size() == 1) {
      result(i) = knot[0];
      continue;
    }
    const double share = (static_cast<double>(i) - at[k]) / (at[k + 1] - at[k]);
    result(i) = (1.0 - share) * knot[k] + share * knot[k + 1];
  }
  return result;
}

// Mean variance of nine lines, none counted with more than nine times their median: past the excitation's
// band sigma rises by orders of magnitude within a line or two.
Eigen::VectorXd smoothed_sigma(const Eigen::VectorXd& sigma) {
  const long n = sigma.size();
  Eigen::VectorXd result(n);
  for (long i = 0; i < n; ++i) {
    const long reach = std::min({half_mean, i, n - 1 - i});  // symmetric, so that a slope leaves no offset
    const Eigen::VectorXd square = sigma.segment(i - reach, 2 * reach + 1).cwiseAbs2();
    result(i) = std::sqrt(square.cwiseMin(9.0 * median({square.begin(), square.end()})).mean());
  }
  return result;
}

}  // namespace

Eigen::VectorXd noise_from_differences(const Eigen::VectorXcd& value) {
  const long n = value.size();
  const Eigen::VectorXd magnitude = running_median(value.cwiseAbs());
  const double smallest = std::max(magnitude.maxCoeff() * 1e-12, least_sigma);
  const Eigen::VectorXd floor = (1e-6 * magnitude).cwiseMax(smallest);
  if (n < 9) return Eigen::VectorXd::Constant(n, std::max(floor.maxCoeff(), 1e-3 * magnitude.maxCoeff()));
  Eigen::VectorXd square(n);
  for (long i = 2; i < n - 2; ++i)
    square(i) =
        std::norm(value(i - 2) - 4.0 * value(i - 1) + 6.0 * value(i) - 4.0 * value(i + 1) + value(i + 2));
  square.head(2).setConstant(square(2));
  square.tail(2).setConstant(square(n - 3));
  // |difference|^2 is 2 * 70 sigma^2 times an exponential variable of mean 1, whose median is ln 2.
  const Eigen::VectorXd sigma = (running_median(square) / (140.0 * std::numbers::ln2)).cwiseSqrt();
  return sigma.cwiseMax(floor);
}

TransferFunction with_noise_floor(const TransferFunction& tf) {
  TransferFunction result = tf;
  for (auto& output : result.outputs) {
    if (output.sigma.size() == 0) {
      output.sigma = noise_from_differences(output.value);
      continue;
    }
    // A line of coherence one claims no noise at all; rounding is the least there is.
    const Eigen::VectorXd magnitude = running_median(output.value.cwiseAbs());
    const double smallest = std::max(magnitude.maxCoeff() * 1e-15, least_sigma);
    output.sigma = smoothed_sigma(output.sigma).cwiseMax(1e-9 * magnitude).cwiseMax(smallest);
  }
  return result;
}

bool has_sigma(const TransferFunction& tf) {
  return std::all_of(tf.outputs.begin(), tf.outputs.end(),
                     [](const auto& output) { return output.sigma.size() > 0; });
}

}  // namespace struna::ident
