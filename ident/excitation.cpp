#include "ident/excitation.hpp"

#include <algorithm>
#include <cmath>

#include "ident/window.hpp"

namespace struna::ident {
namespace {

constexpr long segments_looked_at = 15;
constexpr long fewest_samples = 64;  // of a segment
constexpr double least_echo =
    0.35;  // of the autocorrelation: two periods have a half, less what noise there is
constexpr double near_largest =
    0.8;  // a multiple of the period may have a higher peak than the period itself
constexpr double most_difference = 0.02;  // of the power, between a record and itself a period later
constexpr int most_candidates = 50;

bool repeats_after(const Eigen::VectorXd& input, long period) {
  const long rest = input.size() - period;
  const double mean = input.mean();
  const double power = (input.array() - mean).square().mean();
  const double difference = (input.tail(rest) - input.head(rest)).squaredNorm() / static_cast<double>(rest);
  return difference <= 2.0 * most_difference * power;
}

}  // namespace

double participation(const Eigen::VectorXd& power, const Eigen::VectorXd& square, long segments) {
  double sum = 0.0;
  double weight = 0.0;
  for (long i = 1; i < square.size(); ++i) {
    if (square[i] == 0.0) continue;
    sum += std::sqrt(power[i]) * power[i] * power[i] / (static_cast<double>(segments) * square[i]);
    weight += std::sqrt(power[i]);
  }
  return weight > 0.0 ? sum / weight : 1.0;
}

bool passes_over_lines(const Eigen::VectorXd& input) {
  const long length = smooth_length(input.size() / segments_looked_at);
  if (length < fewest_samples) return false;
  Fft fft(length);
  const Eigen::VectorXd taper = hann_window(length);
  Eigen::VectorXd power = Eigen::VectorXd::Zero(length / 2 + 1);
  Eigen::VectorXd square = power;
  const double mean = input.mean();
  for (long k = 0; k < segments_looked_at; ++k) {
    fft.input() = (input.segment(k * length, length).array() - mean) * taper.array();
    const Eigen::VectorXd p = fft.transform().cwiseAbs2();
    power += p;
    square += p.cwiseAbs2();
  }
  return participation(power, square, segments_looked_at) < passing_excitation;
}

long find_period(const Eigen::VectorXd& input, const Eigen::Ref<const Eigen::VectorXcd>& transform,
                 Fft& fft) {
  const Eigen::VectorXd r = circular_autocorrelation(transform, fft);
  const long last = std::min(input.size() / 2, r.size() - 1);
  long first = 1;
  while (first <= last && r[first] > 0.0) ++first;
  if (first > last || !(r[0] > 0.0)) return 0;
  const double largest = r.segment(first, last - first + 1).maxCoeff();
  if (largest < least_echo * r[0]) return 0;
  int candidates = 0;
  for (long lag = first; lag <= last && candidates < most_candidates; ++lag) {
    if (r[lag] < near_largest * largest || r[lag] < r[lag - 1]) continue;
    if (lag + 1 < r.size() && r[lag] < r[lag + 1]) continue;
    ++candidates;
    if (repeats_after(input, lag)) return lag;
  }
  return 0;
}

}  // namespace struna::ident
