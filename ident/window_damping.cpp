#include "ident/window_damping.hpp"

#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace struna::ident {

Pole without_window(const Pole& pole, double decay, fem::Damping damping) {
  const double shift = decay / (2.0 * std::numbers::pi);
  const double f = pole.natural_frequency_hz;
  if (damping == fem::Damping::structural) {
    const std::complex<double> root =
        f * std::sqrt(std::complex<double>(1.0, pole.loss_factor)) - std::complex<double>(0.0, shift);
    const std::complex<double> square = root * root;
    return {std::sqrt(square.real()), square.imag() / square.real()};
  }
  const double zeta = 0.5 * pole.loss_factor;
  const double damped = f * std::sqrt(1.0 - zeta * zeta);
  const double decay_rate = zeta * f - shift;
  const double undamped = std::hypot(damped, decay_rate);
  return {undamped, 2.0 * decay_rate / undamped};
}

namespace {

void take_out(double decay, fem::Damping damping, Stabilisation& stabilisation) {
  std::vector<int> place;  // of each column among those that stay
  std::vector<StableColumn> columns;
  for (StableColumn& column : stabilisation.columns) {
    column.pole = without_window(column.pole, decay, damping);
    const bool stays = column.pole.loss_factor > 0.0;
    place.push_back(stays ? static_cast<int>(columns.size()) : -1);
    if (stays) columns.push_back(std::move(column));
  }
  stabilisation.columns = std::move(columns);
  std::erase_if(stabilisation.poles, [&](OrderPole& found) {
    found.pole = without_window(found.pole, decay, damping);
    if (found.column >= 0) found.column = place[static_cast<std::size_t>(found.column)];
    return !(found.pole.loss_factor > 0.0);
  });
}

}  // namespace

void take_out_window_damping(double decay, fem::Damping damping, ModeSet& set) {
  if (decay == 0.0) return;
  take_out(decay, damping, set.stabilisation);
  std::erase_if(set.modes, [&](Mode& mode) {
    const Pole own = without_window({mode.natural_frequency_hz, mode.loss_factor}, decay, damping);
    const double added = mode.loss_factor - own.loss_factor;
    const double wider = bandwidth_hz({mode.natural_frequency_hz, mode.loss_factor}) / bandwidth_hz(own);
    if (!(own.loss_factor > 0.0)) {
      set.rejected.push_back(
          {mode.natural_frequency_hz,
           fmt::format("loss factor {:.3g} not above the {:.3g} that the exponential window added",
                       mode.loss_factor, added)});
      return true;
    }
    mode.natural_frequency_hz = own.natural_frequency_hz;
    mode.loss_factor = own.loss_factor;
    mode.resolves_from *= wider;
    const Pole circle =
        without_window({mode.circle_natural_frequency_hz, mode.circle_loss_factor}, decay, damping);
    mode.circle_natural_frequency_hz = circle.natural_frequency_hz;
    mode.circle_loss_factor = circle.loss_factor;
    mode.damping_ratio = 0.5 * mode.loss_factor;
    const Pole pole{mode.natural_frequency_hz, mode.loss_factor};
    mode.lower_half_power_hz = lower_half_power_hz(pole, damping);
    mode.upper_half_power_hz = upper_half_power_hz(pole, damping);
    return false;
  });
}

}  // namespace struna::ident
