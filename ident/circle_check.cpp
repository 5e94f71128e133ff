#include "ident/circle_check.hpp"

#include <algorithm>
#include <cmath>

#include "ident/band_fit.hpp"
#include "ident/mode_flags.hpp"
#include "ident/mode_groups.hpp"

namespace struna::ident {
namespace {

constexpr double bent = 0.01;         // of the bandwidth, of the loss factor
constexpr double one_in_2000 = 3.48;  // standard deviations, either sign

double distance_hz(const Mode& a, const Mode& b) {
  return std::abs(a.natural_frequency_hz - b.natural_frequency_hz);
}

const Mode* nearest(const std::vector<Mode>& modes, const Mode& to) {
  const auto best = std::min_element(modes.begin(), modes.end(), [&](const Mode& a, const Mode& b) {
    return distance_hz(a, to) < distance_hz(b, to);
  });
  return best == modes.end() ? nullptr : &*best;
}

// The circle's pole in the fit together: each the other's nearest, within a bandwidth.
const Mode* counterpart(const std::vector<Mode>& together, const std::vector<Mode>& circles,
                        const Mode& circle) {
  const Mode* const mode = nearest(together, circle);
  const bool is_its_own = mode != nullptr && nearest(circles, *mode) == &circle &&
                          distance_hz(*mode, circle) < bandwidth_hz(pole_of(circle));
  return is_its_own ? mode : nullptr;
}

// One value of a circle beside that of the fit together.
struct Comparison {
  double distance = 0.0;
  double circle_sigma = 0.0;
  double together_sigma = 0.0;

  double sigma() const { return std::max(circle_sigma, std::hypot(distance, together_sigma)); }
  bool is_bent(double unit) const {
    const double variance = circle_sigma * circle_sigma - together_sigma * together_sigma;
    return distance > bent * unit && distance > one_in_2000 * std::sqrt(std::max(0.0, variance));
  }
};

void judge(const Mode& together, Mode& circle) {
  const Comparison frequency{distance_hz(circle, together), circle.natural_frequency_sigma,
                             together.natural_frequency_sigma};
  const Comparison loss_factor{std::abs(circle.loss_factor - together.loss_factor), circle.loss_factor_sigma,
                               together.loss_factor_sigma};
  circle.natural_frequency_sigma = frequency.sigma();
  circle.loss_factor_sigma = loss_factor.sigma();
  circle.resolves_from = together.resolves_from;
  for (const ModeFlag flag : {ModeFlag::double_mode, ModeFlag::may_be_two})
    if (together.has(flag)) add_flag(circle, flag);
  if (frequency.is_bent(bandwidth_hz(pole_of(circle))) || loss_factor.is_bent(circle.loss_factor))
    add_flag(circle, ModeFlag::close_modes);
}

// Whether the fit together had too few lines to tell anything of it.
bool lacked_lines(const BandFit& together, const Mode& circle) {
  return std::any_of(together.rejected.begin(), together.rejected.end(), [&](const RejectedCandidate& r) {
    return std::abs(r.frequency_hz - circle.natural_frequency_hz) < bandwidth_hz(pole_of(circle)) &&
           r.reason == too_few_lines;
  });
}

}  // namespace

void judge_circles(const TransferFunction& circle_form_tf, fem::Damping damping, bool sigma_known,
                   std::vector<Mode>& circles) {
  BandFitOptions options;
  options.damping = damping;
  options.sigma_known = sigma_known;
  options.search_residual = false;
  const BandFit together = fit_band(circle_form_tf, circles, options);
  for (Mode& circle : circles) {
    const Mode* const own = counterpart(together.modes, circles, circle);
    if (own != nullptr)
      judge(*own, circle);
    else if (!lacked_lines(together, circle))
      add_flag(circle, ModeFlag::close_modes);
  }
}

}  // namespace struna::ident
