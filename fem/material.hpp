#pragma once

#include <string>
#include <vector>

namespace struna::fem {

/// A positive quantity over frequency: E(f) [Pa] or eta(f) [-]. What a fit returns is what the model eats.
///
/// kind             parameters                     value at f [Hz]
/// constant         {c}                            c
/// power            {c, n, f0}                     c (f/f0)^n
/// fractional_zener {c0, ratio, f_relax, order}    c0 Re[(1 + ratio z)/(1 + z)], z = (i f/f_relax)^order  (Pritz,
///                                                 J. Sound Vib. 195 (1996) 103, eq. 4; ratio = E_inf/E_0):
///                                                 from c0 up (ratio > 1) or down to ratio c0; 0 < order <= 1
/// monotone_spline  frequency, value (knots)       monotone piecewise cubic in ln f (Fritsch & Carlson 1980);
///                                                 beyond the knots the end value; 2 or more knots
/// table            frequency, value               linear between entries in f; beyond them the end value
struct FrequencyLaw {
  enum class Kind { constant, power, fractional_zener, monotone_spline, table };

  Kind kind = Kind::constant;
  std::vector<double> parameters;
  std::vector<double> frequency;  ///< knots [Hz], increasing; empty for the closed forms
  std::vector<double> value;      ///< at the knots
  double valid_from_hz = 0.0;     ///< range of the data behind the law; 0, 0: not known, valid anywhere
  double valid_to_hz = 0.0;

  /// Value at f > 0 [Hz].
  double at(double f_hz) const;
  /// d ln(value) / d ln f at f [-], analytic. At a kink (a table's entry, the end knots) the slope of one side; 0
  /// where the value is 0 throughout.
  double log_slope(double f_hz) const;
  /// Whether f lies outside the range of the data behind the law.
  bool extrapolates_at(double f_hz) const;
};

/// Checks a law: parameter count and ranges, knots increasing, values positive (zero allowed where
/// `allow_zero`). Throws Error naming `what`, the rule and the value.
void validate(const FrequencyLaw& law, const std::string& what, bool allow_zero = false);

/// "constant", "power", "fractional_zener", "monotone_spline", "table" and back; throws Error on another word.
std::string to_string(FrequencyLaw::Kind kind);
FrequencyLaw::Kind law_kind(const std::string& word);

FrequencyLaw constant_law(double value);

/// Proportional viscous damping C = alpha M + beta K, physics eq. (9). K at the modulus of the frequency at hand.
struct Rayleigh {
  double alpha = 0.0;  ///< [1/s]
  double beta = 0.0;   ///< [s]
};

/// zeta = (alpha/omega + beta omega)/2, eq. (10), at omega = 2 pi f.
double rayleigh_damping_ratio(const Rayleigh& rayleigh, double f_hz);

enum class Damping { structural, viscous };

std::string to_string(Damping damping);
Damping damping_kind(const std::string& word);  ///< throws Error on another word

struct Material {
  FrequencyLaw youngs_modulus;                  ///< E(f) [Pa]
  FrequencyLaw loss_factor = {FrequencyLaw::Kind::constant, {0.0}, {}, {}, 0.0, 0.0};  ///< eta(f) [-]
  Rayleigh rayleigh;
  Damping damping = Damping::structural;        ///< which of the two acts
};

}  // namespace struna::fem
