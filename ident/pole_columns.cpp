#include "ident/pole_columns.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
constexpr double smallest_loss_factor = 1e-7, largest_loss_factor = 1.5;

// a (g + m) + b i (g - m): the share of c = a + i b and its mirror image.
void put(Eigen::MatrixXd& columns, long lines, long i, long first, const Complex& g, const Complex& m) {
  columns(i, first) = g.real() + m.real();
  columns(lines + i, first) = g.imag() + m.imag();
  columns(i, first + 1) = -g.imag() + m.imag();
  columns(lines + i, first + 1) = g.real() - m.real();
}

}  // namespace

long residual_count(ResidualTerms terms) {
  return terms == ResidualTerms::constant ? 1 : terms == ResidualTerms::linear ? 2 : 3;
}

Eigen::MatrixXd residual_shapes(const Eigen::VectorXd& omega, FrfKind kind, ResidualTerms terms) {
  Eigen::ArrayXd w = omega.array();
  const long lines = omega.size();
  if (kind != FrfKind::mobility) w = w.square().eval();
  const double middle = 0.5 * (w(0) + w(lines - 1)), half = 0.5 * (w(lines - 1) - w(0));
  const Eigen::ArrayXd t = (w - middle) / half;
  const Eigen::ArrayXd inverse =
      terms == ResidualTerms::band ? Eigen::ArrayXd(middle / w) : Eigen::ArrayXd::Ones(lines);
  const std::array<Eigen::ArrayXd, 3> term = {inverse, inverse * t, inverse * (1.5 * t.square() - 0.5)};
  Eigen::MatrixXd shapes(lines, residual_count(terms));
  for (long j = 0; j < shapes.cols(); ++j) shapes.col(j) = term[static_cast<std::size_t>(j)];
  return shapes;
}

std::array<Complex, 2> pole_slopes(const Pole& pole, fem::Damping damping) {
  const double omega = 2.0 * std::numbers::pi * pole.natural_frequency_hz, eta = pole.loss_factor;
  if (damping == fem::Damping::structural)
    return {-2.0 * omega * omega * Complex(1.0, eta), -omega * omega * Complex(0.0, eta)};
  const double zeta = 0.5 * eta;
  return {viscous_root(pole), -zeta * omega * Complex(1.0, zeta / std::sqrt(1.0 - zeta * zeta))};
}

std::array<Complex, 2> scaled_slopes(const Pole& pole, fem::Damping damping) {
  auto slopes = pole_slopes(pole, damping);
  for (Complex& slope : slopes) slope /= pole_scale(pole, damping);
  return slopes;
}

void fill_pole_columns(const Pole& pole, const Eigen::VectorXd& omega, fem::Damping damping, bool mirror,
                       long first, long square, Eigen::MatrixXd& columns) {
  const double scale = pole_scale(pole, damping);
  for (long i = 0; i < omega.size(); ++i) {
    const Complex g = scale * pole_function(pole, omega(i), damping);
    const Complex m = mirror ? std::conj(scale * pole_function(pole, -omega(i), damping)) : 0.0;
    put(columns, omega.size(), i, first, g, m);
    put(columns, omega.size(), i, square, g * g, m * m);
  }
}

void hold_at_bounds(const std::vector<Pole>& poles, Eigen::VectorXd& gradient, Eigen::MatrixXd& hessian) {
  for (std::size_t r = 0; r < poles.size(); ++r) {
    const long at = 2 * static_cast<long>(r) + 1;
    const bool beyond = gradient(at) > 0.0 ? poles[r].loss_factor >= largest_loss_factor
                                           : poles[r].loss_factor <= smallest_loss_factor;
    if (!beyond) continue;
    gradient(at) = 0.0;
    hessian.row(at).setZero();
    hessian.col(at).setZero();
    hessian(at, at) = 1.0;
  }
}

std::vector<Pole> moved(const std::vector<Pole>& poles, const Eigen::VectorXd& delta, double* taken) {
  double share = 1.0;
  for (std::size_t r = 0; r < poles.size(); ++r) {
    const double f_step = std::abs(delta(2 * static_cast<long>(r))),
                 eta_step = std::abs(delta(2 * static_cast<long>(r) + 1));
    share =
        std::min({share, poles[r].loss_factor / std::max(f_step, 1e-300), 1.0 / std::max(eta_step, 1e-300)});
  }
  std::vector<Pole> result = poles;
  for (std::size_t r = 0; r < poles.size(); ++r) {
    const long at = 2 * static_cast<long>(r);
    result[r].natural_frequency_hz *= std::exp(share * delta(at));
    result[r].loss_factor = std::clamp(poles[r].loss_factor * std::exp(share * delta(at + 1)),
                                       smallest_loss_factor, largest_loss_factor);
  }
  if (taken != nullptr) *taken = share;
  return result;
}

double size_of(const Eigen::VectorXd& delta, const std::vector<Pole>& poles) {
  double size = 0.0;
  for (std::size_t r = 0; r < poles.size(); ++r) {
    const long at = 2 * static_cast<long>(r);
    size = std::max({size, std::abs(delta(at)) / poles[r].loss_factor, std::abs(delta(at + 1))});
  }
  return size;
}

double line_correlation(const Eigen::MatrixXcd& residual) {
  const long lines = residual.rows(), outputs = residual.cols();
  const double power = residual.squaredNorm();
  double sum = 1.0;
  for (long lag = 1; lag <= 3 && lag < lines; ++lag) {
    const Complex product =
        residual.topRows(lines - lag).conjugate().cwiseProduct(residual.bottomRows(lines - lag)).sum();
    const double correlation = power > 0.0 ? product.real() / power : 0.0;
    if (correlation > 2.0 / std::sqrt(2.0 * static_cast<double>(lines * outputs))) sum += 2.0 * correlation;
  }
  return sum;
}

Eigen::MatrixXcd shared_noise(const Eigen::MatrixXcd& residual, double line_correlation) {
  constexpr double standard_errors = 3.0;
  const long outputs = residual.cols();
  Eigen::MatrixXcd rho = residual.transpose() * residual.conjugate();
  const Eigen::VectorXd size = rho.diagonal().real().cwiseMax(1e-300).cwiseSqrt();
  const double least =
      standard_errors * std::sqrt(line_correlation / static_cast<double>(std::max(1L, residual.rows())));
  for (long k = 0; k < outputs; ++k)
    for (long l = 0; l < outputs; ++l) {
      rho(k, l) = k == l ? Complex(1.0) : rho(k, l) / (size(k) * size(l));
      if (k != l && std::abs(rho(k, l)) < least) rho(k, l) = 0.0;
    }
  return rho;
}

Eigen::MatrixXd score_covariance_of(const std::vector<Eigen::MatrixXcd>& derivative,
                                    const Eigen::MatrixXcd& shared) {
  const long unknowns = derivative.front().cols();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (long k = 0; k < shared.rows(); ++k) {
    Eigen::MatrixXcd with = Eigen::MatrixXcd::Zero(derivative.front().rows(), unknowns);
    for (long l = 0; l < shared.cols(); ++l)
      if (shared(k, l) != 0.0) with += shared(k, l) * derivative[static_cast<std::size_t>(l)];
    sum += (derivative[static_cast<std::size_t>(k)].adjoint() * with).real();
  }
  return sum;
}

}  // namespace struna::ident
