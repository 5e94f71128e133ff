#include "fem/material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// A value and its derivative with respect to ln f.
struct ValueAndSlope {
  double value = 0.0;
  double slope = 0.0;
};

ValueAndSlope power_law(const std::vector<double>& p, double f_hz) {
  const double value = p[0] * std::pow(f_hz / p[2], p[1]);
  return {value, p[1] * value};
}

/// c0 Re[(1 + R z)/(1 + z)] = c0 [R + (1 - R) g], g = Re 1/(1 + z) = (1 + r c)/(1 + 2 r c + r^2), with r =
/// |z| and c = cos(pi alpha/2). g falls from 1 to 0, so the law runs from c0 to R c0. dr/d ln f = alpha r.
ValueAndSlope fractional_zener(const std::vector<double>& p, double f_hz) {
  const double ratio = p[1];
  const double alpha = p[3];
  const double r = std::pow(f_hz / p[2], alpha);
  const double c = std::cos(0.5 * std::numbers::pi * alpha);
  const double denominator = 1.0 + r * (2.0 * c + r);
  if (!std::isfinite(denominator)) return {p[0] * ratio, 0.0};  // far above the relaxation
  const double g = (1.0 + r * c) / denominator;
  const double dg_dr = -(c + r * (2.0 + c * r)) / denominator / denominator;
  return {p[0] * (ratio + (1.0 - ratio) * g), p[0] * (1.0 - ratio) * dg_dr * alpha * r};
}

/// Index k of the interval [x_k, x_k+1] that holds f; f strictly inside the knots.
std::size_t interval(const std::vector<double>& knots, double f_hz) {
  const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, f_hz);
  return static_cast<std::size_t>(above - knots.begin()) - 1;
}

ValueAndSlope linear_table(const FrequencyLaw& law, double f_hz) {
  const std::size_t k = interval(law.frequency, f_hz);
  const double df = law.frequency[k + 1] - law.frequency[k];
  const double gradient = (law.value[k + 1] - law.value[k]) / df;
  const double value = law.value[k] + gradient * (f_hz - law.frequency[k]);
  return {value, f_hz * gradient};
}

/// Secant of interval k over x = ln f.
double secant(const FrequencyLaw& law, std::size_t k) {
  return (law.value[k + 1] - law.value[k]) / std::log(law.frequency[k + 1] / law.frequency[k]);
}

/// Mean of the neighbouring secants, zero at an extremum, the secant itself at the ends.
double first_tangent(const FrequencyLaw& law, std::size_t k) {
  if (k == 0) return secant(law, 0);
  const double before = secant(law, k - 1);
  if (k + 1 == law.frequency.size()) return before;
  const double after = secant(law, k);
  return before * after > 0.0 ? 0.5 * (before + after) : 0.0;
}

/// Factor that brings interval k's pair of first tangents into the circle of radius 3 (over the secant) in
/// which the cubic is monotone (Fritsch & Carlson 1980, sec. 4, region S2).
double tangent_limit(const FrequencyLaw& law, std::size_t k) {
  const double d = secant(law, k);
  if (d == 0.0) return 1.0;  // both first tangents are zero already
  const double radius = std::hypot(first_tangent(law, k), first_tangent(law, k + 1)) / std::abs(d);
  return radius > 3.0 ? 3.0 / radius : 1.0;
}

/// The tangent shared by two intervals, held to the smaller of their limits: the region is star-shaped, so
/// both stay inside.
double monotone_tangent(const FrequencyLaw& law, std::size_t k) {
  double limit = 1.0;
  if (k > 0) limit = tangent_limit(law, k - 1);
  if (k + 1 < law.frequency.size()) limit = std::min(limit, tangent_limit(law, k));
  return limit * first_tangent(law, k);
}

ValueAndSlope monotone_spline(const FrequencyLaw& law, double f_hz) {
  const std::size_t k = interval(law.frequency, f_hz);
  const double h = std::log(law.frequency[k + 1] / law.frequency[k]);
  const double t = std::log(f_hz / law.frequency[k]) / h;
  const double m0 = h * monotone_tangent(law, k);
  const double m1 = h * monotone_tangent(law, k + 1);
  const double rise = law.value[k + 1] - law.value[k];
  // Hermite cubic in nested form: y0 + t (m0 + t (3 rise - 2 m0 - m1 + t (m0 + m1 - 2 rise))).
  const double b = 3.0 * rise - 2.0 * m0 - m1;
  const double a = m0 + m1 - 2.0 * rise;
  return {law.value[k] + t * (m0 + t * (b + t * a)), (m0 + t * (2.0 * b + t * 3.0 * a)) / h};
}

ValueAndSlope evaluate(const FrequencyLaw& law, double f_hz) {
  switch (law.kind) {
    case FrequencyLaw::Kind::constant:
      return {law.parameters[0], 0.0};
    case FrequencyLaw::Kind::power:
      return power_law(law.parameters, f_hz);
    case FrequencyLaw::Kind::fractional_zener:
      return fractional_zener(law.parameters, f_hz);
    case FrequencyLaw::Kind::monotone_spline:
    case FrequencyLaw::Kind::table:
      break;
  }
  if (f_hz <= law.frequency.front()) return {law.value.front(), 0.0};
  if (f_hz >= law.frequency.back()) return {law.value.back(), 0.0};
  return law.kind == FrequencyLaw::Kind::table ? linear_table(law, f_hz) : monotone_spline(law, f_hz);
}

struct KindName {
  FrequencyLaw::Kind kind;
  const char* name;
};
constexpr std::array<KindName, 5> kind_names = {{{FrequencyLaw::Kind::constant, "constant"},
                                                 {FrequencyLaw::Kind::power, "power"},
                                                 {FrequencyLaw::Kind::fractional_zener, "fractional_zener"},
                                                 {FrequencyLaw::Kind::monotone_spline, "monotone_spline"},
                                                 {FrequencyLaw::Kind::table, "table"}}};

[[noreturn]] void refuse(const std::string& what, const std::string& rule) {
  throw Error(fmt::format("{}: {}", what, rule));
}

void check_positive(const std::string& what, const char* name, double value, bool allow_zero = false) {
  if (!std::isfinite(value) || value < 0.0 || (value == 0.0 && !allow_zero)) {
    refuse(what,
           fmt::format("{} must be {}, got {}", name, allow_zero ? "zero or positive" : "positive", value));
  }
}

void check_knots(const FrequencyLaw& law, const std::string& what, std::size_t least, bool allow_zero) {
  if (law.frequency.size() != law.value.size()) {
    refuse(what, fmt::format("frequency and value must have equal length, got {} and {}",
                             law.frequency.size(), law.value.size()));
  }
  if (law.frequency.size() < least) {
    refuse(what, fmt::format("a {} needs {} or more entries, got {}", to_string(law.kind), least,
                             law.frequency.size()));
  }
  for (std::size_t k = 0; k < law.frequency.size(); ++k) {
    check_positive(what, "frequency [Hz]", law.frequency[k]);
    check_positive(what, "value", law.value[k], allow_zero);
    if (k > 0 && law.frequency[k] <= law.frequency[k - 1]) {
      refuse(what, fmt::format("frequency must increase, got {} Hz after {} Hz", law.frequency[k],
                               law.frequency[k - 1]));
    }
  }
}

void check_parameter_count(const FrequencyLaw& law, const std::string& what, std::size_t count) {
  if (law.parameters.size() != count) {
    refuse(what, fmt::format("a {} law takes {} parameter{}, got {}", to_string(law.kind), count,
                             count == 1 ? "" : "s", law.parameters.size()));
  }
}

}  // namespace

double FrequencyLaw::at(double f_hz) const {
  return evaluate(*this, f_hz).value;
}

double FrequencyLaw::log_slope(double f_hz) const {
  const ValueAndSlope v = evaluate(*this, f_hz);
  return v.slope == 0.0 ? 0.0 : v.slope / v.value;
}

bool FrequencyLaw::extrapolates_at(double f_hz) const {
  return valid_to_hz > 0.0 && (f_hz < valid_from_hz || f_hz > valid_to_hz);
}

void validate(const FrequencyLaw& law, const std::string& what, bool allow_zero) {
  const std::vector<double>& p = law.parameters;
  switch (law.kind) {
    case FrequencyLaw::Kind::constant:
      check_parameter_count(law, what, 1);
      check_positive(what, "value", p[0], allow_zero);
      break;
    case FrequencyLaw::Kind::power:
      check_parameter_count(law, what, 3);
      check_positive(what, "value", p[0], allow_zero);
      if (!std::isfinite(p[1])) refuse(what, fmt::format("exponent must be finite, got {}", p[1]));
      check_positive(what, "reference_frequency [Hz]", p[2]);
      break;
    case FrequencyLaw::Kind::fractional_zener:
      check_parameter_count(law, what, 4);
      check_positive(what, "value", p[0], allow_zero);
      check_positive(what, "ratio", p[1]);
      check_positive(what, "relaxation_frequency [Hz]", p[2]);
      check_positive(what, "order", p[3]);
      if (p[3] > 1.0) refuse(what, fmt::format("order must be at most 1, got {}", p[3]));
      break;
    case FrequencyLaw::Kind::monotone_spline:
      check_parameter_count(law, what, 0);
      check_knots(law, what, 2, allow_zero);
      break;
    case FrequencyLaw::Kind::table:
      check_parameter_count(law, what, 0);
      check_knots(law, what, 1, allow_zero);
      break;
  }
  const bool range_known = law.valid_from_hz != 0.0 || law.valid_to_hz != 0.0;
  if (range_known && !(law.valid_from_hz >= 0.0 && law.valid_to_hz >= law.valid_from_hz)) {
    refuse(what, fmt::format("the valid range must run upwards from 0 Hz or more, got {} to {} Hz",
                             law.valid_from_hz, law.valid_to_hz));
  }
}

std::string to_string(FrequencyLaw::Kind kind) {
  for (const KindName& entry : kind_names) {
    if (entry.kind == kind) return entry.name;
  }
  throw Error("to_string: no such kind of law");
}

FrequencyLaw::Kind law_kind(const std::string& word) {
  for (const KindName& entry : kind_names) {
    if (word == entry.name) return entry.kind;
  }
  throw Error(
      fmt::format("law: constant, power, fractional_zener, monotone_spline or table, got \"{}\"", word));
}

FrequencyLaw constant_law(double value) {
  return {FrequencyLaw::Kind::constant, {value}, {}, {}, 0.0, 0.0};
}

double rayleigh_damping_ratio(const Rayleigh& rayleigh, double f_hz) {
  const double omega = 2.0 * std::numbers::pi * f_hz;
  return 0.5 * (rayleigh.alpha / omega + rayleigh.beta * omega);
}

std::string to_string(Damping damping) {
  return damping == Damping::structural ? "structural" : "viscous";
}

Damping damping_kind(const std::string& word) {
  if (word == "structural") return Damping::structural;
  if (word == "viscous") return Damping::viscous;
  throw Error(fmt::format("damping: structural or viscous, got \"{}\"", word));
}

}  // namespace struna::fem
