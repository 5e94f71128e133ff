#include "apps/limit_laws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "ident/law_fit.hpp"
#include "ident/rayleigh_flag.hpp"

namespace struna::apps {
namespace {

/// Stated in docs/limits.md, relative.
constexpr double damping_tolerance = 0.05;
constexpr double modulus_tolerance = 0.005;

double geometric(double lo, double hi, int index, int count) {
  return count == 1 ? std::sqrt(lo * hi) : lo * std::pow(hi / lo, static_cast<double>(index) / (count - 1));
}

double rayleigh_sigma(const ident::RayleighFit& fit, double f_hz) {
  const double omega = 2.0 * std::numbers::pi * f_hz;
  const double a = 0.5 / omega, b = 0.5 * omega;
  return std::sqrt(std::max(0.0, a * a * fit.alpha_sigma * fit.alpha_sigma +
                                     b * b * fit.beta_sigma * fit.beta_sigma + 2.0 * a * b * fit.covariance));
}

/// The laws of eight moduli with a standard error of 0.2 %, the chosen one first.
std::vector<ident::LawFit> fitted_modulus(const fem::FrequencyLaw& truth, unsigned seed) {
  using Kind = fem::FrequencyLaw::Kind;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  constexpr int points = 8;
  Eigen::VectorXd f(points), value(points), sigma(points);
  for (int i = 0; i < points; ++i) {
    f[i] = geometric(50.0, 500.0, i, points);
    sigma[i] = 0.002 * truth.at(f[i]);
    value[i] = truth.at(f[i]) + sigma[i] * normal(engine);
  }
  return ident::fit_laws(f, value, sigma,
                         {Kind::constant, Kind::power, Kind::fractional_zener, Kind::monotone_spline}, true);
}

}  // namespace

LimitMap rayleigh_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "rayleigh";
  map.title = "Rayleigh coefficients from modes that contradict them";
  map.quantity = "damping ratio at the worst of five frequencies (relative)";
  map.fails = "two coefficients cannot follow the damping, or too few modes have tested whether they do";
  map.sign = "the distance of the modes from the curve beyond their standard errors, and their number";
  map.then = "flags them contradicted or two_modes; from one mode it gives beta alone, flagged one_mode";
  map.axes = {run.axis("modes [-]", {1, 2, 3, 4, 5, 6, 8, 10}),
              run.axis("share of constant damping [%]", {0, 1, 3, 10, 30, 60, 100}),
              run.axis("standard error of a mode [%]", {0.3, 1, 3})};
  const fem::Rayleigh truth{10.0, 2e-5};
  const double constant = fem::rayleigh_damping_ratio(truth, 126.0);
  for_each_place(map.axes, [&](const std::vector<double>& at) {
    const double share = 0.01 * at[1], sigma = 0.01 * at[2];
    const auto ratio = [&](double f) {
      return (1.0 - share) * fem::rayleigh_damping_ratio(truth, f) + share * constant;
    };
    for (const unsigned seed : run.draws(10)) {
      std::mt19937_64 engine(seed);
      std::normal_distribution<double> normal;
      const int modes = static_cast<int>(at[0]);
      Eigen::VectorXd f(modes), zeta(modes), error(modes);
      for (int i = 0; i < modes; ++i) {
        f[i] = geometric(20.0, 800.0, i, modes);
        zeta[i] = ratio(f[i]) * (1.0 + sigma * normal(engine));
        error[i] = ratio(f[i]) * sigma;
      }
      const ident::RayleighFit fit = ident::fit_rayleigh(f, zeta, error);
      LimitTrial trial;
      trial.at = at;
      trial.seed = seed;
      trial.tolerance = damping_tolerance;
      for (const double at_hz : {20.0, 50.0, 126.0, 320.0, 800.0}) {
        const double off = std::abs(fem::rayleigh_damping_ratio(fit.rayleigh, at_hz) / ratio(at_hz) - 1.0);
        const double stated = rayleigh_sigma(fit, at_hz) / ratio(at_hz);
        if (std::isfinite(trial.sigma) && !(off * trial.sigma > trial.error * stated)) continue;
        trial.error = off;
        trial.sigma = stated;
      }
      trial.flags = to_string(ident::rayleigh_flag(fit));
      trial.refused = !fit.determined;
      map.trials.push_back(std::move(trial));
    }
  });
  return map;
}

LimitMap extrapolation_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "extrapolation";
  map.title = "E(f) fitted from 50 to 500 Hz, told elsewhere";
  map.quantity = "modulus (relative)";
  map.fails = "beyond the data several laws go on as well as each other and part";
  map.sign = "their distance there, weighted by how well they fit, which the standard error holds";
  map.then = "flags the frequency as extrapolated where that error exceeds 1 %";
  map.axes = {run.axis("frequency [Hz]", {5, 10, 20, 40, 60, 100, 200, 300, 450, 600, 1000, 2000, 5000}),
              run.axis("rise from rest to fast [%]", {0, 1, 3, 10, 30, 100}),
              run.axis("relaxation frequency [Hz]", {20, 150, 1000})};
  for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& material) {
    const fem::FrequencyLaw truth{fem::FrequencyLaw::Kind::fractional_zener,
                                  {1e11, 1.0 + 0.01 * material[0], material[1], 0.6},
                                  {},
                                  {},
                                  0.0,
                                  0.0};
    for (const unsigned seed : run.draws(6)) {
      const std::vector<ident::LawFit> laws = fitted_modulus(truth, seed);
      for (const double f : map.axes[0].values) {
        LimitTrial trial;
        trial.at = {f, material[0], material[1]};
        trial.seed = seed;
        trial.error = std::abs(laws.front().law.at(f) / truth.at(f) - 1.0);
        trial.sigma = ident::law_sigma(laws, f) / truth.at(f);
        trial.tolerance = modulus_tolerance;
        if (ident::is_extrapolated(laws, f)) trial.flags = "extrapolated";
        map.trials.push_back(std::move(trial));
      }
    }
  });
  return map;
}

}  // namespace struna::apps
