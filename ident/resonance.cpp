#include "ident/resonance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace struna::ident {
namespace {

// 1/z without the library's care for infinities, which costs more than all the rest.
std::complex<double> reciprocal(const std::complex<double>& z) {
  return std::conj(z) / std::norm(z);
}

double omega_of(const Pole& pole) {
  return 2.0 * std::numbers::pi * pole.natural_frequency_hz;
}

}  // namespace

std::complex<double> viscous_root(const Pole& pole) {
  const double zeta = 0.5 * pole.loss_factor;
  return omega_of(pole) * std::complex<double>(-zeta, std::sqrt(1.0 - zeta * zeta));
}

std::complex<double> pole_function(const Pole& pole, double omega, fem::Damping damping) {
  if (damping == fem::Damping::viscous)
    return reciprocal(std::complex<double>(0.0, omega) - viscous_root(pole));
  const double lambda = omega_of(pole) * omega_of(pole);
  return reciprocal({lambda - omega * omega, lambda * pole.loss_factor});
}

double pole_scale(const Pole& pole, fem::Damping damping) {
  const double omega_r = omega_of(pole);
  return damping == fem::Damping::viscous ? 0.5 * pole.loss_factor * omega_r
                                          : pole.loss_factor * omega_r * omega_r;
}

std::complex<double> modal_share(const std::complex<double>& constant, const Pole& pole, double omega,
                                 fem::Damping damping) {
  const std::complex<double> share = constant * pole_function(pole, omega, damping);
  if (damping == fem::Damping::structural) return share;
  return share + std::conj(constant * pole_function(pole, -omega, damping));
}

double angle_coordinate(const Pole& pole, double f_hz, fem::Damping damping) {
  const double ratio = f_hz / pole.natural_frequency_hz;
  if (damping == fem::Damping::structural) return (1.0 - ratio * ratio) / pole.loss_factor;
  const double zeta = 0.5 * pole.loss_factor;
  return (std::sqrt(1.0 - zeta * zeta) - ratio) / zeta;
}

double lower_half_power_hz(const Pole& pole, fem::Damping damping) {
  if (damping == fem::Damping::structural)
    return pole.natural_frequency_hz * std::sqrt(std::max(0.0, 1.0 - pole.loss_factor));
  const double zeta = 0.5 * pole.loss_factor;
  return pole.natural_frequency_hz * (std::sqrt(1.0 + zeta * zeta) - zeta);
}

double upper_half_power_hz(const Pole& pole, fem::Damping damping) {
  if (damping == fem::Damping::structural)
    return pole.natural_frequency_hz * std::sqrt(1.0 + pole.loss_factor);
  const double zeta = 0.5 * pole.loss_factor;
  return pole.natural_frequency_hz * (std::sqrt(1.0 + zeta * zeta) + zeta);
}

double bandwidth_hz(const Pole& pole) {
  return pole.loss_factor * pole.natural_frequency_hz;
}

double half_power_loss_factor(double lower_hz, double upper_hz, double resonance_hz, fem::Damping damping) {
  if (damping == fem::Damping::viscous) return (upper_hz - lower_hz) / resonance_hz;
  return (upper_hz * upper_hz - lower_hz * lower_hz) / (2.0 * resonance_hz * resonance_hz);
}

}  // namespace struna::ident
