#include "ident/group_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ident/modal_assurance.hpp"
#include "ident/mode_flags.hpp"
#include "ident/schwarz_penalty.hpp"

namespace struna::ident {
namespace {

constexpr double smallest_loss_factor = 1e-5, largest_loss_factor = 0.5;
constexpr double least_lines = 0.3;         // line spacings in the half-power band
constexpr double least_significance = 6.0;  // of the constants, in standard errors
constexpr double least_beside = 3.0;        // the same of a pole beside the window
constexpr double most_outside = 3.0;        // bandwidths that it may be beside it
constexpr double least_share = 0.03;        // of the function around
constexpr double one_pole = 0.05;           // bandwidths: nearer poles count as one
constexpr double reach_of_shape = 8.0;      // bandwidths within which a second pole is looked for
constexpr double parallel = 0.9;            // modal assurance
constexpr double noise_alone = 1.5;  // chi-square per degree of freedom of a model that explains the lines

}  // namespace

bool GroupFit::can_fit(std::size_t poles) const {
  return 2 * window_->lines() * outputs() >
         static_cast<long>(2 * poles) + outputs() * static_cast<long>(2 * poles + 6);
}

void GroupFit::fit(const std::vector<Pole>& poles) {
  fit_ = fit_poles(*window_, poles, options_);
}

double GroupFit::lack() const {
  return fit_.chi_square / static_cast<double>(fit_.degrees_of_freedom);
}

double GroupFit::penalty() const {
  const double scatter = options_.sigma_known ? std::max(1.0, lack()) : lack();
  return schwarz_penalty({static_cast<double>(2 + 2 * outputs()),
                          2.0 * static_cast<double>(window_->lines() * outputs()), fit_.line_correlation,
                          scatter});
}

std::pair<long, long> GroupFit::lines_around(const Pole& pole, double bandwidths) const {
  const double reach = std::max(bandwidths * bandwidth_hz(pole), 1.01 * spacing_);
  const auto begin = window_->frequency_hz.data(), end = begin + window_->lines();
  const long first = std::lower_bound(begin, end, pole.natural_frequency_hz - reach) - begin;
  const long last = std::upper_bound(begin, end, pole.natural_frequency_hz + reach) - begin;
  return {first, last};
}

double GroupFit::significance(long r) const {
  return std::sqrt(
      (fit_.constant.row(r).cwiseAbs2().array() / fit_.constant_sigma.row(r).array().square()).sum() / 2.0);
}

double GroupFit::share(long r) const {
  const double f = pole(r).natural_frequency_hz, omega = 2.0 * std::numbers::pi * f;
  const auto at = std::lower_bound(window_->frequency_hz.begin(), window_->frequency_hz.end(), f);
  const long line = std::min(window_->lines() - 1, static_cast<long>(at - window_->frequency_hz.begin()));
  double own = 0.0, all = 0.0;
  for (long k = 0; k < outputs(); ++k) {
    const double sigma = window_->outputs[static_cast<std::size_t>(k)].sigma(line);
    std::complex<double> rest = fit_.fitted(line, k);
    double sum = 0.0;
    for (long s = 0; s < static_cast<long>(fit_.poles.size()); ++s) {
      rest -= modal_share(fit_.constant(s, k), pole(s), 2.0 * std::numbers::pi * window_->frequency_hz(line),
                          options_.damping);
      sum += std::abs(modal_share(fit_.constant(s, k), pole(s), omega, options_.damping));
    }
    for (const Mode& mode : *outside_)
      sum += std::abs(modal_share(mode.modal_constant(k), pole_of(mode), omega, options_.damping));
    own += std::norm(modal_share(fit_.constant(r, k), pole(r), omega, options_.damping)) / (sigma * sigma);
    all += std::pow((sum + std::abs(rest)) / sigma, 2.0);
  }
  return std::sqrt(own / all);
}

double GroupFit::scatter_of(long r) const {
  constexpr long lag = 2;  // lines: noise is independent from there on, also behind a Hann window (nearly)
  const auto [first, last] = lines_around(pole(r), 1.0);
  const long n = last - first - lag;
  if (n < 1) return 0.0;
  double structure = 0.0, radius = 0.0;
  for (long k = 0; k < outputs(); ++k) {
    const auto& sigma = window_->outputs[static_cast<std::size_t>(k)].sigma;
    const double unit = sigma.segment(first, last - first).squaredNorm() / static_cast<double>(last - first);
    const auto residual = fit_.residual.col(k).cwiseProduct(sigma);
    structure += residual.segment(first, n).dot(residual.segment(first + lag, n)).real() /
                 (static_cast<double>(n) * unit);
    radius += std::norm(0.5 * fit_.constant(r, k) / pole_scale(pole(r), options_.damping)) / unit;
  }
  return std::sqrt(std::max(0.0, structure) / radius);
}

bool GroupFit::is_poor(long r) const {
  const auto [first, last] = lines_around(pole(r), 1.0);
  const long n = last - first;
  if (n < 1) return false;
  const double misfit =
      0.5 * fit_.residual.middleRows(first, n).squaredNorm() / static_cast<double>(n * outputs());
  double scatter = 1.0;
  for (long k = 0; k < outputs(); ++k) {
    const auto& sigma = window_->outputs[static_cast<std::size_t>(k)].sigma;
    const double off = fit_.residual.col(k).segment(first, n).cwiseProduct(sigma.segment(first, n)).norm();
    const double radius = std::abs(0.5 * fit_.constant(r, k) / pole_scale(pole(r), options_.damping));
    scatter = std::min(scatter, off / (radius * std::sqrt(static_cast<double>(n))));
  }
  return misfit > poor_circle_misfit * poor_circle_misfit && scatter > poor_circle_scatter;
}

double GroupFit::assurance(long r, long s) const {
  const Eigen::VectorXd weight = fit_.constant_sigma.row(r).transpose().cwiseInverse();
  return modal_assurance(weight.asDiagonal() * fit_.constant.row(r).transpose(),
                         weight.asDiagonal() * fit_.constant.row(s).transpose());
}

SecondPole GroupFit::second_pole(long r) const {
  const auto [first, last] = lines_around(pole(r), reach_of_shape);
  return ident::second_pole(lines_of_pole(fit_, r, *window_, first, last, options_.damping));
}

bool GroupFit::is_double(long r) const {
  const auto [first, last] = lines_around(pole(r), 1.0);
  if (last - first < 1) return false;
  const LinesOfPole lines = lines_of_pole(fit_, r, *window_, first, last, options_.damping);
  return looks_double(alone(lines), lines.g);
}

std::string GroupFit::objection(long r) const {
  const Pole& p = pole(r);
  // Outside the band nothing tells its damping, and its constants are one with the residual terms: what it
  // took out of the sum of squares when it was added is its support, and nobody claims it.
  const Span background{band_.lo_hz / beyond_band, band_.hi_hz * beyond_band};
  if (!background.holds(p.natural_frequency_hz)) return "carried off by the fit";
  if (!band_.holds(p.natural_frequency_hz)) return "";
  if (p.loss_factor < smallest_loss_factor || p.loss_factor > largest_loss_factor)
    return fmt::format("loss factor {:.3g} outside {:g} to {:g}", p.loss_factor, smallest_loss_factor,
                       largest_loss_factor);
  if (bandwidth_hz(p) < least_lines * spacing_)
    return fmt::format("half-power band {:.3g} Hz far below the line spacing {:.3g} Hz", bandwidth_hz(p),
                       spacing_);
  const double outside = std::max(window_->frequency_hz(0) - p.natural_frequency_hz,
                                  p.natural_frequency_hz - window_->frequency_hz(window_->lines() - 1));
  if (outside > most_outside * bandwidth_hz(p)) return "carried off by the fit";
  if (!(significance(r) > (outside > 0.0 ? least_beside : least_significance)))
    return fmt::format("modal constants only {:.2g} standard errors", significance(r));
  if (outside <= 0.0 && !(share(r) > least_share))
    return fmt::format("only {:.2g} % of the function around it", 100.0 * share(r));
  for (long s = 0; s < static_cast<long>(fit_.poles.size()); ++s) {
    if (s == r || significance(s) < significance(r)) continue;
    const double distance = std::abs(p.natural_frequency_hz - pole(s).natural_frequency_hz);
    const double bandwidth = std::max(bandwidth_hz(p), bandwidth_hz(pole(s)));
    if (distance < one_pole * bandwidth)
      return fmt::format("one with the mode at {:.6g} Hz", pole(s).natural_frequency_hz);
    if (distance < bandwidth && assurance(r, s) > parallel && (!options_.sigma_known || lack() > noise_alone))
      return fmt::format("mends the shape of the mode at {:.6g} Hz", pole(s).natural_frequency_hz);
  }
  return "";
}

std::optional<long> GroupFit::worst(long targets) const {
  std::optional<long> found;
  for (long r = 0; r < targets; ++r)
    if (!objection(r).empty() && (!found || !(significance(r) > significance(*found)))) found = r;
  return found;
}

void weigh_model_error(const TransferFunction& noise, const Eigen::MatrixXcd& residual,
                       TransferFunction& window) {
  for (std::size_t k = 0; k < window.outputs.size(); ++k) {
    Eigen::VectorXd& sigma = window.outputs[k].sigma;
    const Eigen::VectorXd variance = noise.outputs[k].sigma.cwiseAbs2();
    const double excess =
        0.5 * residual.col(static_cast<long>(k)).cwiseAbs2().cwiseProduct(sigma.cwiseAbs2()).mean() -
        variance.mean();
    sigma = (variance.array() + std::max(0.0, excess)).sqrt();
  }
}

}  // namespace struna::ident
