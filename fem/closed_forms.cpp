#include "fem/closed_forms.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;

double angular(double f_hz) {
  return 2.0 * std::numbers::pi * f_hz;
}

/// b with b^4 = rho A w^2 m/(E I k) for complex mass and stiffness scales m, k.
Complex wave_number(const ClampedBeam& beam, Complex stiffness_scale, Complex mass_scale, double f_hz) {
  if (!(f_hz > 0.0)) throw Error(fmt::format("closed form: frequency must be positive, got {:g} Hz", f_hz));
  const double omega = angular(f_hz);
  return std::pow(
      beam.mass_per_length * omega * omega / beam.bending_stiffness * mass_scale / stiffness_scale, 0.25);
}

/// The functions of x that the support forces share, all times e^-x: hyperbolic functions of a long beam
/// overflow.
struct Scaled {
  Complex sinh;      ///< sinh x e^-x
  Complex cosh;      ///< cosh x e^-x
  Complex decay;     ///< e^-x
  Complex resonant;  ///< (1 - cos x cosh x) e^-x
};

/// 1 - cos x cosh x = -sum over k >= 1 of (-4)^k x^4k/(4k)!: without the cancellation at small x.
Complex one_minus_cos_cosh_series(Complex x) {
  const Complex x4 = x * x * x * x;
  Complex term = 1.0;
  Complex sum = 0.0;
  for (int k = 1; k <= 8; ++k) {
    const double n = 4.0 * k;
    term *= -4.0 * x4 / (n * (n - 1.0) * (n - 2.0) * (n - 3.0));
    sum -= term;
  }
  return sum;
}

Scaled scaled_functions(Complex x) {
  const Complex decay = std::exp(-x);
  const Complex sinh = std::abs(x) < 1.0 ? std::sinh(x) * decay : 0.5 * (1.0 - decay * decay);
  const Complex cosh = 0.5 * (1.0 + decay * decay);
  const Complex resonant =
      std::abs(x) < 1.0 ? one_minus_cos_cosh_series(x) * decay : decay - std::cos(x) * cosh;
  return {sinh, cosh, decay, resonant};
}

Complex stiffness_factor(const ClampedBeam& beam, double loss_factor, Complex b) {
  return beam.bending_stiffness * Complex(1.0, loss_factor) * b * b * b;
}

}  // namespace

double clamped_clamped_root(int mode) {
  if (mode < 1) throw Error(fmt::format("clamped_clamped_root: modes count from 1, got {}", mode));
  // cos x - 1/cosh x has the same roots and does not overflow; Newton from its asymptote is safe for all
  // modes.
  double x = (mode + 0.5) * std::numbers::pi;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const double sech = 1.0 / std::cosh(x);
    x -= (std::cos(x) - sech) / (-std::sin(x) + sech * std::tanh(x));
  }
  return x;
}

double natural_frequency_hz(const ClampedBeam& beam, int mode) {
  const double b = clamped_clamped_root(mode) / beam.length;
  return b * b * std::sqrt(beam.bending_stiffness / beam.mass_per_length) / (2.0 * std::numbers::pi);
}

Complex far_support_stiffness(const ClampedBeam& beam, double loss_factor, double f_hz) {
  const Complex b = wave_number(beam, Complex(1.0, loss_factor), 1.0, f_hz);
  const Complex x = b * beam.length;
  const Scaled f = scaled_functions(x);
  return -stiffness_factor(beam, loss_factor, b) * (std::sin(x) * f.decay + f.sinh) / f.resonant;
}

Complex shaken_support_stiffness(const ClampedBeam& beam, double loss_factor, double f_hz) {
  const Complex b = wave_number(beam, Complex(1.0, loss_factor), 1.0, f_hz);
  const Complex x = b * beam.length;
  const Scaled f = scaled_functions(x);
  return stiffness_factor(beam, loss_factor, b) * (std::cos(x) * f.sinh + std::sin(x) * f.cosh) / f.resonant;
}

Complex both_supports_stiffness(const ClampedBeam& beam, Complex stiffness_scale, Complex mass_scale,
                                double f_hz) {
  const Complex b = wave_number(beam, stiffness_scale, mass_scale, f_hz);
  const Complex half = 0.5 * b * beam.length;
  const double omega = angular(f_hz);
  return -4.0 * beam.mass_per_length * mass_scale * omega * omega /
         (b * (1.0 / std::tan(half) + 1.0 / std::tanh(half)));
}

}  // namespace struna::fem
