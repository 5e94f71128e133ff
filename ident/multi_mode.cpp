#include "ident/multi_mode.hpp"

#include <algorithm>
#include <cmath>

#include "ident/noise_floor.hpp"
#include "ident/pole_fit.hpp"

namespace struna::ident {

MultiModeFit fit_multi_mode(const TransferFunction& circle_form_tf, const std::vector<Mode>& start,
                            const MultiModeOptions& options) {
  const bool given = has_sigma(circle_form_tf);
  PoleFitOptions fit_options;
  fit_options.damping = options.damping;
  fit_options.sigma_known = options.sigma_known && given;
  fit_options.max_iterations = options.max_iterations;
  std::vector<Mode> ordered = start;
  std::sort(ordered.begin(), ordered.end(),
            [](const Mode& a, const Mode& b) { return a.natural_frequency_hz < b.natural_frequency_hz; });
  std::vector<Pole> poles;
  for (const Mode& mode : ordered) poles.push_back({mode.natural_frequency_hz, mode.loss_factor});
  const PoleFit fit =
      fit_poles(given ? circle_form_tf : with_noise_floor(circle_form_tf), poles, fit_options);

  MultiModeFit result;
  result.fitted = fit.fitted;
  result.converged = fit.converged;
  result.weighted_rms = std::sqrt(fit.chi_square / static_cast<double>(fit.degrees_of_freedom));
  for (std::size_t r = 0; r < poles.size(); ++r) {
    Mode mode = to_mode(fit, static_cast<long>(r), options.damping);
    mode.circle_natural_frequency_hz = ordered[r].circle_natural_frequency_hz;
    mode.circle_loss_factor = ordered[r].circle_loss_factor;
    mode.circles = ordered[r].circles;
    mode.window_lo_hz = ordered[r].window_lo_hz;
    mode.window_hi_hz = ordered[r].window_hi_hz;
    result.modes.push_back(std::move(mode));
  }
  std::sort(result.modes.begin(), result.modes.end(),
            [](const Mode& a, const Mode& b) { return a.natural_frequency_hz < b.natural_frequency_hz; });
  return result;
}

}  // namespace struna::ident
