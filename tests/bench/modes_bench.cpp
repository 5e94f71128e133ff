// Modes from a transfer function: time against accuracy on the eight-mode set (4800 lines, 3 outputs), one
// thread, shortest of several runs. Rows: method, knob (noise in % of the rms), value (modes found, of
// eight), error (of frequency and of loss factor, root mean square over the modes, in Cramer-Rao bounds),
// time [s]. Advice: auto finds all modes at the bound; circle alone is as quick but some bounds off, as
// neighbours' tails bend the arcs; half-power is for a first look.

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "ident/mode_identification.hpp"
#include "ident/pole_fit.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/ident/simulated_modes.hpp"

namespace {

using namespace struna;
using namespace struna::ident;

// The modes nearest to the true ones, in units of their bounds.
struct Error {
  double frequency = 0.0;
  double loss_factor = 0.0;
};
Error error_of(const ModeSet& set, const PoleFit& bound) {
  Error error;
  const auto truth = simulated::eight_modes();
  for (std::size_t r = 0; r < truth.size(); ++r) {
    double nearest = std::numeric_limits<double>::infinity(), loss_factor = nearest;
    for (const Mode& mode : set.modes)
      if (std::abs(mode.natural_frequency_hz - truth[r].pole.natural_frequency_hz) < std::abs(nearest)) {
        nearest = mode.natural_frequency_hz - truth[r].pole.natural_frequency_hz;
        loss_factor = mode.loss_factor - truth[r].pole.loss_factor;
      }
    const long i = 2 * static_cast<long>(r);
    error.frequency += nearest * nearest / bound.covariance(i, i) / 8.0;
    error.loss_factor += loss_factor * loss_factor / bound.covariance(i + 1, i + 1) / 8.0;
  }
  return {std::sqrt(error.frequency), std::sqrt(error.loss_factor)};
}

void row(const std::string& method, double level, const ModeSet& set, const PoleFit& bound, double seconds) {
  const Error error = error_of(set, bound);
  fmt::print("{:<24}{:>8g}{:>8}{:>12.2f}{:>12.2f}{:>12.4f}\n", method, 100.0 * level, set.modes.size(),
             error.frequency, error.loss_factor, seconds);
}

}  // namespace

int main() {
  fmt::print("{:<24}{:>8}{:>8}{:>12}{:>12}{:>12}\n", "method", "noise %", "modes", "f error", "eta error",
             "time [s]");
  std::vector<Pole> poles;
  for (const auto& mode : simulated::eight_modes()) {
    poles.push_back(mode.pole);
  }
  for (const double level : {0.01, 0.05}) {
    const TransferFunction tf = simulated::eight_mode_set(level, 1);
    const TransferFunction form = to_circle_form(tf, fem::Damping::structural);
    const PoleFit bound = fit_poles(form, poles, {});
    PoleFit fit;
    const double all_at_once = tests::best_seconds(5, [&] { fit = fit_poles(form, poles, {}); });
    ModeSet once;
    for (long r = 0; r < 8; ++r) once.modes.push_back(to_mode(fit, r, fem::Damping::structural));
    row("all at once, from truth", level, once, bound, all_at_once);
    for (const ModeMethod method :
         {ModeMethod::automatic, ModeMethod::multi, ModeMethod::circle, ModeMethod::half_power}) {
      ModeOptions options;
      options.method = method;
      ModeSet set;
      const double seconds = tests::best_seconds(5, [&] { set = identify_modes(tf, options); });
      row(to_string(method), level, set, bound, seconds);
    }
  }
}
