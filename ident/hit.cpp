#include "ident/hit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

double median(const Eigen::VectorXd& values) {
  std::vector<double> sorted(values.begin(), values.end());
  const auto middle = sorted.begin() + static_cast<long>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

/// Whether a pulse of at least `threshold` follows the end of the one at `peak`.
bool has_second_pulse(const Eigen::VectorXd& deviation, long start, long peak, double threshold) {
  long end = peak;
  while (end < deviation.size() && deviation[end] >= 0.5 * threshold) ++end;
  // Ringing of the force cell right after the pulse is not a hit: one pulse length of grace.
  end = std::min<long>(deviation.size(), end + (end - start));
  return end < deviation.size() && deviation.tail(deviation.size() - end).maxCoeff() >= threshold;
}

}  // namespace

Hit find_hit(const Eigen::VectorXd& force) {
  const Eigen::VectorXd deviation = (force.array() - median(force)).abs();
  Hit hit;
  const double largest = deviation.maxCoeff(&hit.peak);
  if (!(largest > 0.0)) throw Error("find_hit: the force is constant: there is no hit in it");
  const double pulse = 0.1 * largest;
  long rise = hit.peak;
  while (rise > 0 && deviation[rise - 1] >= pulse) --rise;
  const double scatter =
      rise >= 8 ? 3.0 * std::sqrt(deviation.head(rise / 2).squaredNorm() / static_cast<double>(rise / 2))
                : 0.0;
  const double onset = std::min(pulse, std::max(0.02 * largest, scatter));
  hit.start = rise;
  while (hit.start > 0 && deviation[hit.start - 1] >= onset) --hit.start;
  hit.second = has_second_pulse(deviation, hit.start, hit.peak, pulse);
  return hit;
}

Eigen::RowVectorXd rest_values(const Eigen::MatrixXd& samples, const Hit& hit) {
  if (hit.start >= 8) return samples.topRows(hit.start).colwise().mean();
  Eigen::RowVectorXd rest(samples.cols());
  for (long k = 0; k < samples.cols(); ++k) rest[k] = median(samples.col(k));
  return rest;
}

}  // namespace struna::ident
