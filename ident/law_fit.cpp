#include "ident/law_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "fem/error.hpp"
#include "ident/least_squares.hpp"

namespace struna::ident {
namespace {

using fem::FrequencyLaw;
using Kind = FrequencyLaw::Kind;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double indifferent_aicc =
    2.0;  // two laws closer than this are equally good (Burnham & Anderson 2002, sec. 2.6)
constexpr int most_knots = 6;

struct Points {
  Eigen::VectorXd frequency_hz;
  Eigen::VectorXd value;
  Eigen::VectorXd sigma;

  int count() const { return static_cast<int>(value.size()); }
};

void check(const Points& p) {
  if (p.frequency_hz.size() != p.value.size() || p.sigma.size() != p.value.size()) {
    throw Error(fmt::format("fit_laws: frequency, value and sigma must have equal length, got {}, {} and {}",
                            p.frequency_hz.size(), p.value.size(), p.sigma.size()));
  }
  if (p.count() == 0) throw Error("fit_laws: at least one point, got none");
  for (Eigen::Index i = 0; i < p.value.size(); ++i) {
    const bool positive = p.frequency_hz[i] > 0.0 && p.value[i] > 0.0 && p.sigma[i] > 0.0;
    if (!positive || !std::isfinite(p.frequency_hz[i] + p.value[i] + p.sigma[i])) {
      throw Error(fmt::format(
          "fit_laws: frequency, value and sigma must be positive, got {} Hz, {} and {} at point {}",
          p.frequency_hz[i], p.value[i], p.sigma[i], i + 1));
    }
  }
}

/// A law in the terms that are fitted: unbounded or boxed numbers of order one.
///   constant         ln c
///   power            ln c, n                       (reference frequency: the data's geometric mean, where c
///   and n part) fractional_zener ln c0, ln ratio, ln f_relax, order monotone_spline  ln of the first knot's
///   value, then the steps of ln value from knot to knot
struct Parametrisation {
  Kind kind = Kind::constant;
  std::vector<double> knots;  ///< [Hz], monotone_spline
  double reference_hz = 0.0;  ///< power
  Eigen::VectorXd start;
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
};

FrequencyLaw law_of(const Parametrisation& p, const Eigen::VectorXd& x) {
  FrequencyLaw law;
  law.kind = p.kind;
  switch (p.kind) {
    case Kind::constant:
      law.parameters = {std::exp(x[0])};
      break;
    case Kind::power:
      law.parameters = {std::exp(x[0]), x[1], p.reference_hz};
      break;
    case Kind::fractional_zener:
      law.parameters = {std::exp(x[0]), std::exp(x[1]), std::exp(x[2]), x[3]};
      break;
    case Kind::monotone_spline:
    case Kind::table: {
      law.frequency = p.knots;
      double logarithm = 0.0;
      for (double step : x) law.value.push_back(std::exp(logarithm += step));
      break;
    }
  }
  return law;
}

/// d(the law's own numbers)/d(the fitted ones).
Eigen::MatrixXd own_from_fitted(const FrequencyLaw& law, Eigen::Index fitted) {
  switch (law.kind) {
    case Kind::constant:
      return Eigen::MatrixXd::Constant(1, 1, law.parameters[0]);
    case Kind::power: {
      Eigen::MatrixXd chain = Eigen::MatrixXd::Zero(3, 2);
      chain(0, 0) = law.parameters[0];
      chain(1, 1) = 1.0;
      return chain;
    }
    case Kind::fractional_zener:
      return Eigen::Vector4d(law.parameters[0], law.parameters[1], law.parameters[2], 1.0).asDiagonal();
    case Kind::monotone_spline:
    case Kind::table:
      break;
  }
  Eigen::MatrixXd chain = Eigen::MatrixXd::Zero(fitted, fitted);  // ln value is the running sum of the steps
  for (Eigen::Index k = 0; k < fitted; ++k)
    chain.row(k).head(k + 1).setConstant(law.value[static_cast<std::size_t>(k)]);
  return chain;
}

Eigen::VectorXd log_residuals(const Points& points, const FrequencyLaw& law) {
  Eigen::VectorXd r(points.count());
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    r[i] = std::log(law.at(points.frequency_hz[i]) / points.value[i]) * points.value[i] / points.sigma[i];
  }
  return r;
}

/// Akaike's criterion of k parameters and n points at a scatter of `variance` sigma^2 that all laws share, so
/// that a law cannot excuse its misfit by calling it scatter. Hurvich and Tsai's correction for few points
/// has n - k - 1, as their variance is taken from the same fit; here it is not, so that a law with one degree
/// of freedom left can still be judged. Infinite without any.
double aicc(double chi_square, double variance, int n, int k) {
  if (n - k < 1) return infinity;
  return chi_square / variance + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k);
}

struct Fitted {
  LawFit fit;
  LeastSquaresSolution solution;

  double chi_square() const { return solution.residual.squaredNorm(); }
  int parameters() const { return static_cast<int>(solution.x.size()); }
};

Fitted fit_one(const Points& points, const Parametrisation& parametrisation) {
  LeastSquares problem;
  problem.residual = [&](const Eigen::VectorXd& x) {
    return log_residuals(points, law_of(parametrisation, x));
  };
  problem.start = parametrisation.start;
  problem.lower = parametrisation.lower;
  problem.upper = parametrisation.upper;
  Fitted result;
  result.solution = solve_least_squares(problem);
  LawFit& fit = result.fit;
  fit.law = law_of(parametrisation, result.solution.x);
  fit.law.valid_from_hz = points.frequency_hz.minCoeff();
  fit.law.valid_to_hz = points.frequency_hz.maxCoeff();
  fit.rms = result.solution.rms();
  const Eigen::MatrixXd chain = own_from_fitted(fit.law, result.solution.x.size());
  const double scale = std::pow(std::max(1.0, fit.rms), 2.0);
  fit.covariance = scale * chain * result.solution.covariance * chain.transpose();
  fit.parameter_sigma = fit.covariance.diagonal().cwiseSqrt();
  return result;
}

Parametrisation unbounded(Kind kind, const Eigen::VectorXd& start) {
  Parametrisation p;
  p.kind = kind;
  p.start = start;
  p.lower = Eigen::VectorXd::Constant(start.size(), -infinity);
  p.upper = Eigen::VectorXd::Constant(start.size(), infinity);
  return p;
}

double mean_log(const Eigen::VectorXd& v) {
  return v.array().log().mean();
}

Fitted fit_constant(const Points& points) {
  return fit_one(points, unbounded(Kind::constant, Eigen::VectorXd::Constant(1, mean_log(points.value))));
}

std::optional<Fitted> fit_power(const Points& points) {
  if (points.count() < 2) return std::nullopt;
  Parametrisation p = unbounded(Kind::power, Eigen::VectorXd{{mean_log(points.value), 0.0}});
  p.reference_hz = std::exp(mean_log(points.frequency_hz));
  const Fitted fitted = fit_one(points, p);
  if (!fitted.solution.determined) return std::nullopt;  // all points at one frequency
  return fitted;
}

/// Offered only when the points show the relaxation: six of them, no parameter on a bound (an order of 1 is
/// the classical Zener model and may stand), and each known to within a factor of e or so.
std::optional<Fitted> fit_fractional_zener(const Points& points, bool rising) {
  if (points.count() < 6) return std::nullopt;
  const double f_lo = points.frequency_hz.minCoeff();
  const double f_hi = points.frequency_hz.maxCoeff();
  const double span = std::log(points.value.maxCoeff() / points.value.minCoeff());
  std::optional<Fitted> best;
  for (double place : {0.25, 0.75}) {
    for (double order : {0.4, 0.8}) {
      for (double sign : {1.0, -1.0}) {
        if (rising && sign < 0.0) continue;
        const double low = std::log(sign > 0.0 ? points.value.minCoeff() : points.value.maxCoeff());
        Parametrisation p = unbounded(
            Kind::fractional_zener,
            Eigen::Vector4d(low, sign * 1.2 * span, std::log(f_lo) + place * std::log(f_hi / f_lo), order));
        p.lower << -infinity, rising ? 0.0 : -5.0, std::log(f_lo / 30.0), 0.05;
        p.upper << infinity, 5.0, std::log(f_hi * 30.0), 1.0;
        Fitted fitted = fit_one(points, p);
        if (!best || fitted.chi_square() < best->chi_square()) {
          best = std::move(fitted);
        }
      }
    }
  }
  const LeastSquaresSolution& solution = best->solution;
  const bool on_bound = solution.at_bound[1] || solution.at_bound[2] || solution.x[3] <= 0.05;
  if (on_bound || !solution.determined || !solution.converged) return std::nullopt;
  const Eigen::Vector4d sigma = std::max(1.0, best->fit.rms) * solution.covariance.diagonal().cwiseSqrt();
  const bool known = sigma[1] < std::abs(solution.x[1]) && sigma[2] < 1.0 && sigma[3] < 0.5;
  if (!known) return std::nullopt;
  return best;
}

/// About `count` knots: evenly spread over ln f, each moved to the nearest point so that every knot has data.
std::vector<double> spline_knots(const Points& points, int count) {
  Eigen::VectorXd sorted = points.frequency_hz;
  std::sort(sorted.begin(), sorted.end());
  const double step = std::log(sorted[sorted.size() - 1] / sorted[0]) / (count - 1);
  std::vector<double> knots;
  for (int k = 0; k < count; ++k) {
    const double wanted = std::log(sorted[0]) + k * step;
    const double nearest = *std::min_element(sorted.begin(), sorted.end(), [&](double a, double b) {
      return std::abs(std::log(a) - wanted) < std::abs(std::log(b) - wanted);
    });
    if (knots.empty() || std::log(nearest / knots.back()) > 0.25 * step) knots.push_back(nearest);
  }
  return knots;
}

std::vector<Fitted> fit_monotone_splines(const Points& points, bool rising) {
  std::vector<Fitted> fits;
  for (int count = 3; count <= std::min(most_knots, points.count() - 2); ++count) {
    const std::vector<double> knots = spline_knots(points, count);
    if (static_cast<int>(knots.size()) != count) continue;
    Eigen::VectorXd start = Eigen::VectorXd::Zero(count);
    start[0] = mean_log(points.value);
    if (rising) start.tail(count - 1).setConstant(1e-3);  // inside the bounds
    Parametrisation p = unbounded(Kind::monotone_spline, start);
    p.knots = knots;
    if (rising) p.lower.tail(count - 1).setZero();
    const Fitted fitted = fit_one(points, p);
    if (fitted.solution.determined) fits.push_back(fitted);
  }
  return fits;
}

std::vector<Fitted> fit_kind(const Points& points, Kind kind, bool rising) {
  const auto if_offered = [](const std::optional<Fitted>& fit) {
    return fit ? std::vector<Fitted>{*fit} : std::vector<Fitted>{};
  };
  switch (kind) {
    case Kind::constant:
      return {fit_constant(points)};
    case Kind::power:
      return if_offered(fit_power(points));
    case Kind::fractional_zener:
      return if_offered(fit_fractional_zener(points, rising));
    case Kind::monotone_spline:
      return fit_monotone_splines(points, rising);
    case Kind::table:
      break;
  }
  throw Error("fit_laws: constant, power, fractional_zener or monotone_spline; a table is not fitted");
}

/// The scatter that the laws leave, in sigma^2: that of the law that explains most per degree of freedom, and
/// not below 1, as the given sigmas are a lower limit.
double common_variance(const std::vector<Fitted>& fits, int n) {
  double least = infinity;
  for (const Fitted& fitted : fits) {
    const int freedom = n - fitted.parameters();
    if (freedom > 0) least = std::min(least, fitted.chi_square() / freedom);
  }
  return std::isfinite(least) ? std::max(1.0, least) : 1.0;
}

/// Of several splines the one that AICc likes; a law of each other kind is alone.
void keep_best_of_each_kind(std::vector<LawFit>& best_first) {
  std::vector<Kind> seen;
  std::erase_if(best_first, [&](const LawFit& fit) {
    const bool known = std::find(seen.begin(), seen.end(), fit.law.kind) != seen.end();
    seen.push_back(fit.law.kind);
    return known;
  });
}

std::size_t parameter_count(const FrequencyLaw& law) {
  if (law.kind == Kind::power) return 2;  // the reference frequency is a choice
  return law.parameters.size() + law.value.size();
}

}  // namespace

FrequencyLaw moved(FrequencyLaw law, const Eigen::VectorXd& step) {
  std::vector<double>& numbers = law.value.empty() ? law.parameters : law.value;
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] += step[static_cast<Eigen::Index>(k)];
  return law;
}

double law_sigma(const LawFit& fit, double f_hz) {
  constexpr double part = 0.01;  // of a standard error: the law is straight over it
  const Eigen::Index n = fit.covariance.rows();
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double step = part * std::sqrt(fit.covariance(k, k));
    if (!(step > 0.0)) continue;
    const Eigen::VectorXd along = step * Eigen::VectorXd::Unit(n, k);
    gradient[k] = (moved(fit.law, along).at(f_hz) - moved(fit.law, -along).at(f_hz)) / (2.0 * step);
  }
  return std::sqrt(std::max(0.0, gradient.dot(fit.covariance * gradient)));
}

double spread_beyond_data(const std::vector<LawFit>& laws, double f_hz) {
  if (laws.empty() || laws.front().covariance.size() == 0 || !laws.front().law.extrapolates_at(f_hz))
    return 0.0;
  const FrequencyLaw& chosen = laws.front().law;
  const bool below = f_hz < chosen.valid_from_hz;
  const double edge = below ? chosen.valid_from_hz : chosen.valid_to_hz;
  const double inside = edge * (below ? 1.0 + 1e-9 : 1.0 - 1e-9);  // a spline is flat from its end knot on
  const double reach = std::log(f_hz / edge);
  const auto best = std::min_element(laws.begin(), laws.end(),
                                     [](const LawFit& a, const LawFit& b) { return a.aicc < b.aicc; });
  const auto departure = [&](const FrequencyLaw& law) { return std::log(law.at(f_hz) / law.at(edge)); };
  double weights = 0.0, variance = 0.0, slope_sigma = 0.0;
  for (const LawFit& fit : laws) {
    if (!(fit.law.at(edge) > 0.0 && fit.law.at(f_hz) > 0.0)) continue;  // a loss factor of nothing
    const double weight = std::isfinite(best->aicc) ? std::exp(0.5 * (best->aicc - fit.aicc))
                          : std::isfinite(fit.aicc) ? 0.0
                                                    : 1.0;
    weights += weight;
    variance += weight * (std::pow(departure(fit.law) - departure(chosen), 2.0) +
                          std::pow(reach * fit.law.log_slope(inside), 2.0));
    if (fit.law.kind == Kind::power && fit.parameter_sigma.size() > 1) slope_sigma = fit.parameter_sigma[1];
  }
  return weights > 0.0 ? std::sqrt(variance / weights + std::pow(2.0 * slope_sigma * reach, 2.0)) : 0.0;
}

double law_sigma(const std::vector<LawFit>& laws, double f_hz) {
  if (laws.empty()) return 0.0;
  const LawFit& chosen = laws.front();
  return std::hypot(law_sigma(chosen, f_hz), spread_beyond_data(laws, f_hz) * chosen.law.at(f_hz));
}

bool is_extrapolated(const std::vector<LawFit>& laws, double f_hz) {
  if (laws.empty() || !laws.front().law.extrapolates_at(f_hz)) return false;
  if (laws.front().covariance.size() == 0) return true;
  return law_sigma(laws, f_hz) > extrapolation_tolerance * laws.front().law.at(f_hz);
}

std::vector<LawFit> fit_laws(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& value,
                             const Eigen::VectorXd& sigma, const std::vector<Kind>& kinds, bool rising) {
  const Points points{frequency_hz, value, sigma};
  check(points);
  std::vector<Fitted> fitted;
  for (Kind kind : kinds) {
    for (Fitted& fit : fit_kind(points, kind, rising)) fitted.push_back(std::move(fit));
  }
  const double variance = common_variance(fitted, points.count());
  std::vector<LawFit> fits;
  for (const Fitted& one : fitted) {
    fits.push_back(one.fit);
    fits.back().aicc = aicc(one.chi_square(), variance, points.count(), one.parameters());
  }
  const auto simpler = [](const LawFit& a, const LawFit& b) {
    return parameter_count(a.law) < parameter_count(b.law);
  };
  std::stable_sort(fits.begin(), fits.end(), simpler);
  std::stable_sort(fits.begin(), fits.end(),
                   [](const LawFit& a, const LawFit& b) { return a.aicc < b.aicc; });
  if (fits.empty()) return fits;
  const auto worse = std::find_if(fits.begin(), fits.end(), [&](const LawFit& fit) {
    return fit.aicc > fits.front().aicc + indifferent_aicc;
  });
  const auto chosen = std::min_element(fits.begin(), worse, simpler);
  std::rotate(fits.begin(), chosen, chosen + 1);
  keep_best_of_each_kind(fits);
  return fits;
}

}  // namespace struna::ident
