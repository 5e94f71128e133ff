#include "ident/pairing_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace struna::ident {
namespace {

constexpr double shape_scale = 0.2;      // [rad] of a true pair's constants about the model's, besides noise
constexpr double right_sign = 0.95;      // of a single output, in a true pair
constexpr double strength_scale = 0.2;   // of ln of a true pair's strength about the common level
constexpr double chance_strength = 2.0;  // the same of a mode that is not the model's
constexpr double calibrated = 0.9;  // probability that the common level is the model's; else it is anywhere …
constexpr double level_range = 14.0;   // … in a range of ln as wide as this: six decades
constexpr double slope_scale = 0.05;   // of the law's slope about the expected one
constexpr double reversed = 0.05;      // probability of a sign reversed throughout
constexpr double least_ln_band = 1.0;  // over which a spurious mode may lie anywhere

double cauchy(double x, double scale) {
  return 1.0 / (std::numbers::pi * scale * (1.0 + x * x / (scale * scale)));
}

double ln_beta(double a, double b) {
  return std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b);
}

/// ln of the integral over the rate r of r^n e^-r, weighted by e^-r.
double ln_spurious(std::size_t n) {
  const double count = static_cast<double>(n);
  return std::lgamma(count + 1.0) - (count + 1.0) * std::numbers::ln2;
}

/// ln of how much more probable this direction over the outputs is in a true pair: the chance p of one as
/// near is uniform among directions drawn at random, and a(1 + a)/(p + a)^2 among true ones.
double shape_gain(double correlation, double noise, int outputs) {
  if (outputs == 1) return std::log(2.0 * (correlation > 0.0 ? right_sign : 1.0 - right_sign));
  const double p = chance_of_angle(std::acos(std::clamp(correlation, -1.0, 1.0)), outputs);
  const double spread = std::sqrt(shape_scale * shape_scale + noise);
  const double a = chance_of_angle(std::min(std::numbers::pi, spread), outputs);
  return std::log(a * (1.0 + a)) - 2.0 * std::log(p + a);
}

/// The same for the strengths: about the model's, or about a common level where units or sensitivities are
/// not the model's.
double strength_gain(std::vector<double> ln_ratio) {
  if (ln_ratio.empty()) return 0.0;
  const auto about = [&](double level) {
    double gain = 0.0;
    for (const double r : ln_ratio)
      gain += std::log(cauchy(r - level, strength_scale)) - std::log(cauchy(r, chance_strength));
    return gain;
  };
  const double model = std::log(calibrated) + about(0.0);
  const auto middle = ln_ratio.begin() + static_cast<std::ptrdiff_t>(ln_ratio.size() / 2);
  std::nth_element(ln_ratio.begin(), middle, ln_ratio.end());
  const double width = std::numbers::pi * strength_scale / level_range;
  return std::max(model, std::log((1.0 - calibrated) * width) + about(*middle));
}

/// ln of the share of the prior range that law and slope keep once the pairs are known.
double law_share(const std::vector<double>& ln_f, const PairingCost::Law& law, double expected_slope,
                 const PairingOptions& options) {
  const auto n = static_cast<double>(ln_f.size());
  double mean = 0.0, squares = 0.0;
  for (const double x : ln_f) mean += x / n;
  for (const double x : ln_f) squares += (x - mean) * (x - mean);
  const double level = 2.0 * pair_frequency_scale / std::sqrt(n);
  const double range = std::log(options.modulus_hi / options.modulus_lo);
  const double slope_precision = squares / std::pow(2.0 * pair_frequency_scale, 2);
  const double slope = 1.0 / std::sqrt(1.0 + slope_precision * slope_scale * slope_scale);
  return std::min(0.0, std::log(std::sqrt(2.0 * std::numbers::pi) * level / range)) + std::log(slope) -
         0.5 * std::pow((law.slope - expected_slope) / slope_scale, 2);
}

}  // namespace

double chance_of_angle(double angle, int dimensions) {
  // J_m = ((m - 1) J_(m-2) - cos sin^(m-1))/m
  const auto integral = [&](double to) {
    double j = dimensions % 2 == 0 ? to : 1.0 - std::cos(to);
    for (int m = 2 + dimensions % 2; m <= dimensions - 2; m += 2)
      j = ((m - 1) * j - std::cos(to) * std::pow(std::sin(to), m - 1)) / m;
    return j;
  };
  return integral(angle) / integral(std::numbers::pi);
}

double pairing_evidence(const PairingCost& cost, const PairingCost::Law& law,
                        const std::vector<int>& explanation, const PairingOptions& options,
                        double frequency_scale) {
  const double ln_band = std::max(least_ln_band, cost.ln_band());
  std::vector<double> ln_f, ln_ratio;
  double ln_odds = 0.0;
  for (std::size_t i = 0; i < explanation.size(); ++i) {
    if (explanation[i] < 0) continue;
    const Candidate& measured = cost.candidates()[i];
    const Explanation& explained = cost.explanation(explanation[i]);
    ln_f.push_back(measured.ln_f);
    const double misfit = measured.ln_f - cost.ln_frequency(law, explained.ln_eigenvalue);
    ln_odds += std::log(ln_band * cauchy(misfit, std::hypot(frequency_scale, measured.ln_f_sigma)));
    if (measured.constant.size() == 0) continue;
    ln_odds += shape_gain(cost.correlation(measured, explained, law), measured.noise,
                          static_cast<int>(measured.constant.size()));
    if (cost.amplitude_known() && explained.constant.norm() > 0.0)
      ln_ratio.push_back(cost.ln_strength_ratio(measured, explained, law));
  }
  if (ln_f.empty()) return 0.0;
  const std::size_t all = explanation.size(), pairs = ln_f.size();
  ln_odds += strength_gain(std::move(ln_ratio));
  // The share of the modes that are seen, integrated over: B(found + 1, missing + 1).
  ln_odds += ln_beta(static_cast<double>(pairs) + 1.0, cost.unseen(law, explanation) + 1.0);
  ln_odds += ln_spurious(all - pairs) - ln_spurious(all);
  ln_odds += law_share(ln_f, law, cost.expected_slope(), options);
  return law.reversed ? ln_odds + std::log(reversed) : ln_odds;
}

}  // namespace struna::ident
