#include "fem/newmark_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace struna::fem {
namespace {

using Complex = std::complex<double>;

Complex true_pole(double omega, double damping_ratio) {
  return omega * (-damping_ratio + std::sqrt(Complex(damping_ratio * damping_ratio - 1.0, 0.0)));
}

}  // namespace

std::complex<double> newmark_pole(const NewmarkOptions& options, double f_hz, double damping_ratio) {
  const double angle = 2.0 * std::numbers::pi * f_hz * options.step;
  const double whole = 1.0 + 2.0 * options.lambda * damping_ratio * angle + options.kappa * angle * angle;
  const double half_trace =
      1.0 - (damping_ratio * angle + 0.5 * angle * angle * (options.lambda + 0.5)) / whole;
  const double determinant =
      1.0 - (2.0 * damping_ratio * angle + angle * angle * (options.lambda - 0.5)) / whole;
  const Complex factor = half_trace + std::sqrt(Complex(half_trace * half_trace - determinant, 0.0));
  return std::log(factor) / options.step;
}

double newmark_error(const NewmarkOptions& options, double highest_hz, const Rayleigh& rayleigh,
                     double duration) {
  constexpr double whole_band = 0.125;
  const double omega = 2.0 * std::numbers::pi * highest_hz;
  const double zeta = rayleigh_damping_ratio(rayleigh, highest_hz);
  const double ringing = std::min(1.0 / std::max(zeta, 1e-12), omega * duration);
  const double shift = std::abs(newmark_pole(options, highest_hz, zeta) - true_pole(omega, zeta)) / omega;
  return whole_band * shift * ringing / std::numbers::sqrt2;
}

}  // namespace struna::fem
