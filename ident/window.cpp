#include "ident/window.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr std::array names = {"auto", "hann", "rectangular", "exponential"};

}  // namespace

Window window_kind(const std::string& word) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (word == names[i]) return static_cast<Window>(i);
  throw Error("window must be auto, hann, rectangular or exponential, got '" + word + "'");
}

std::string to_string(Window window) {
  return names[static_cast<std::size_t>(window)];
}

Eigen::VectorXd hann_window(long samples) {
  const double step = 2.0 * std::numbers::pi / static_cast<double>(samples);
  return Eigen::VectorXd::NullaryExpr(
      samples, [step](Eigen::Index n) { return 0.5 * (1.0 - std::cos(step * static_cast<double>(n))); });
}

Eigen::VectorXd exponential_window(long samples, long hit, double decay, double sample_interval) {
  return Eigen::VectorXd::NullaryExpr(samples, [=](Eigen::Index n) {
    return n <= hit ? 1.0 : std::exp(-decay * sample_interval * static_cast<double>(n - hit));
  });
}

double effective_averages(const Eigen::VectorXd& window, long segments, long hop) {
  const double power = window.squaredNorm();
  const double k = static_cast<double>(segments);
  double correlation = 0.0;
  for (long j = 1; j < segments && j * hop < window.size(); ++j) {
    const long shared = window.size() - j * hop;
    const double rho = window.head(shared).dot(window.tail(shared)) / power;
    correlation += (1.0 - static_cast<double>(j) / k) * rho * rho;
  }
  return k / (1.0 + 2.0 * correlation);
}

long smooth_length(long samples) {
  for (long length = samples; length > 1; --length) {
    long rest = length;
    for (const long prime : {2L, 3L, 5L, 7L})
      while (rest % prime == 0) rest /= prime;
    if (rest == 1) return length;
  }
  return samples;
}

}  // namespace struna::ident
