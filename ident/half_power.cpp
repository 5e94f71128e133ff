#include "ident/half_power.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fem/error.hpp"
#include "ident/resonance.hpp"

namespace struna::ident {
namespace {

// Top of the parabola through line i and its neighbours, as a shift from i in lines and the height there.
struct Top {
  double shift = 0.0;
  double height = 0.0;
};
Top parabola_top(const Eigen::VectorXd& y, long i) {
  if (i == 0 || i + 1 == y.size()) return {0.0, y(i)};
  const double slope = 0.5 * (y(i + 1) - y(i - 1)), curvature = y(i + 1) - 2.0 * y(i) + y(i - 1);
  if (!(curvature < 0.0)) return {0.0, y(i)};
  const double shift = -slope / curvature;
  return {shift, y(i) + 0.5 * slope * shift};
}

double at_line(const Eigen::VectorXd& f, double line) {
  const long i = std::min(static_cast<long>(line), f.size() - 2);
  return f(i) + (line - static_cast<double>(i)) * (f(i + 1) - f(i));
}

// Where y has fallen to `level` going from line i in direction `step`; NaN when it does not.
double crossing(const Eigen::VectorXd& f, const Eigen::VectorXd& y, long i, long step, double level) {
  for (long j = i; j + step >= 0 && j + step < y.size(); j += step)
    if (y(j + step) <= level) {
      const double share = (y(j) - level) / (y(j) - y(j + step));
      return f(j) + share * (f(j + step) - f(j));
    }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Mode fit_half_power(const TransferFunction& circle_form_tf, double start_hz, double lo_hz, double hi_hz,
                    fem::Damping damping) {
  const TransferFunction window = restrict_band(circle_form_tf, lo_hz, hi_hz);
  if (window.lines() < 3)
    throw Error(
        fmt::format("fit_half_power: at least 3 lines in {} to {} Hz, got {}", lo_hz, hi_hz, window.lines()));
  Eigen::VectorXd power = Eigen::VectorXd::Zero(window.lines());
  for (const auto& output : window.outputs)
    power += output.value.cwiseAbs2() / output.value.cwiseAbs2().maxCoeff();

  // Uphill from the line nearest to the start.
  long top = 0;
  (window.frequency_hz.array() - start_hz).abs().minCoeff(&top);
  while (top > 0 && power(top - 1) > power(top)) --top;
  while (top + 1 < window.lines() && power(top + 1) > power(top)) ++top;
  while (top > 0 && power(top - 1) > power(top)) --top;
  const Top peak = parabola_top(power, top);

  Mode mode;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  mode.natural_frequency_hz = at_line(window.frequency_hz, static_cast<double>(top) + peak.shift);
  mode.natural_frequency_sigma = mode.loss_factor_sigma = nan;
  mode.circle_natural_frequency_hz = mode.circle_loss_factor = nan;
  mode.window_lo_hz = window.frequency_hz(0);
  mode.window_hi_hz = window.frequency_hz(window.lines() - 1);
  mode.lower_half_power_hz = crossing(window.frequency_hz, power, top, -1, 0.5 * peak.height);
  mode.upper_half_power_hz = crossing(window.frequency_hz, power, top, 1, 0.5 * peak.height);
  // One flank may end at a neighbour or the window: then the other stands for both.
  if (std::isnan(mode.lower_half_power_hz))
    mode.lower_half_power_hz = 2.0 * mode.natural_frequency_hz - mode.upper_half_power_hz;
  if (std::isnan(mode.upper_half_power_hz))
    mode.upper_half_power_hz = 2.0 * mode.natural_frequency_hz - mode.lower_half_power_hz;
  const long outputs = static_cast<long>(window.outputs.size());
  mode.modal_constant.setZero(outputs);
  mode.modal_constant_sigma.setConstant(outputs, nan);
  if (std::isnan(mode.lower_half_power_hz)) {
    mode.flags.push_back(ModeFlag::not_converged);
    return mode;
  }
  mode.loss_factor = half_power_loss_factor(mode.lower_half_power_hz, mode.upper_half_power_hz,
                                            mode.natural_frequency_hz, damping);
  mode.damping_ratio = 0.5 * mode.loss_factor;
  const Pole pole{mode.natural_frequency_hz, mode.loss_factor};
  const double omega_r = 2.0 * std::numbers::pi * mode.natural_frequency_hz;
  for (long k = 0; k < outputs; ++k)
    mode.modal_constant(k) =
        window.outputs[static_cast<std::size_t>(k)].value(top) / pole_function(pole, omega_r, damping);
  return mode;
}

}  // namespace struna::ident
