#include "ident/leakage.hpp"

#include <cmath>

#include "ident/resonance.hpp"

namespace struna::ident {

double leakage_widening(double seen_half_power_band_hz, double leakage_hz) {
  if (!(leakage_hz > 0.0)) return 0.0;
  const double seen = seen_half_power_band_hz / leakage_hz;  // = n + share/n
  const double rest = seen * seen - 4.0 * leakage_share;
  if (!(rest > 0.0)) return 1.0;
  return 2.0 * seen / (seen + std::sqrt(rest)) - 1.0;
}

double leakage_lowering(double seen_half_power_band_hz, double leakage_hz) {
  const double x = 4.0 / 3.0 / leakage_share * leakage_widening(seen_half_power_band_hz, leakage_hz);
  return x / (1.0 + 2.0 * x);
}

void take_out_leakage(Mode& mode, double leakage_hz, fem::Damping damping) {
  const double widening = leakage_widening(mode.upper_half_power_hz - mode.lower_half_power_hz, leakage_hz);
  if (widening == 0.0) return;
  mode.loss_factor /= 1.0 + widening;
  mode.loss_factor_sigma =
      std::hypot(mode.loss_factor_sigma / (1.0 + widening), leakage_doubt * widening * mode.loss_factor);
  mode.circle_loss_factor /= 1.0 + widening;
  mode.resolves_from *= 1.0 + widening;
  mode.damping_ratio = 0.5 * mode.loss_factor;
  const Pole pole{mode.natural_frequency_hz, mode.loss_factor};
  mode.lower_half_power_hz = lower_half_power_hz(pole, damping);
  mode.upper_half_power_hz = upper_half_power_hz(pole, damping);
}

}  // namespace struna::ident
