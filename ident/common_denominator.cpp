#include "ident/common_denominator.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "ident/line_band.hpp"
#include "ident/polynomial_roots.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
using Eigen::ArrayXd;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;

constexpr double beta = 0.5;  // the band takes 0.7 of the circle, its middle five times as much as its ends
constexpr long extra = 1;     // the numerator's degree above the denominator's: residual terms b + c x
constexpr double model_tolerance = 3e-4;  // of the largest magnitude: no structure follows the model closer
constexpr double rounding = 1e-13;        // of the largest diagonal entry
constexpr double noise_ridge = 1e-6;      // of what noise of one sigma adds to the diagonal

// The band's variable, x = middle + half u.
struct Variable {
  fem::Damping damping;
  double middle;
  double half;

  Variable(const TransferFunction& tf, fem::Damping kind) : damping(kind) {
    const double lo = of(tf.frequency_hz(0)), hi = of(tf.frequency_hz(tf.lines() - 1));
    middle = 0.5 * (lo + hi);
    half = 0.5 * (hi - lo);
  }
  double of(double f_hz) const { return damping == fem::Damping::structural ? f_hz * f_hz : f_hz; }
  Complex at(Complex u) const { return middle + half * u; }
  // x of a pole: f_r^2 (1 + i eta); viscous f_r (sqrt(1 - zeta^2) + i zeta).
  Pole pole(Complex x) const {
    if (damping == fem::Damping::structural) return {std::sqrt(x.real()), x.imag() / x.real()};
    return {std::abs(x), 2.0 * x.imag() / std::abs(x)};
  }
  // Of R/(u - u_p): C/(omega_r^2 (1 + i eta) - omega^2), viscous C/(i omega - p).
  Complex modal_constant(Complex residue) const {
    const double turn = 2.0 * std::numbers::pi;
    return damping == fem::Damping::structural ? -turn * turn * half * residue
                                               : Complex(0.0, turn) * half * residue;
  }
};

Complex numerator_factor(Complex u) {
  Complex factor = 1.0;
  for (long i = 0; i < extra; ++i) factor *= u + Complex(0.0, beta);
  return factor;
}

// Lines x outputs.
Eigen::ArrayXXd floored_sigma(const TransferFunction& tf) {
  Eigen::ArrayXXd sigma(tf.lines(), static_cast<long>(tf.outputs.size()));
  for (long k = 0; k < sigma.cols(); ++k) {
    const auto& output = tf.outputs[static_cast<std::size_t>(k)];
    const double largest = std::sqrt(output.value.cwiseAbs2().maxCoeff());
    sigma.col(k) = output.sigma.array().max(model_tolerance * largest);
  }
  return sigma;
}

// Sums over the lines of weight * z^m: those of the squared numerator basis, of the basis times the function
// and of the squared function, the last over all outputs together.
struct Sums {
  MatrixXcd basis;     // (m = 0 ...) x outputs
  MatrixXcd ahead;     // m = 0, 1 ...
  MatrixXcd behind;    // m = 0, -1 ...
  VectorXcd function;  // m = 0 ...
  double noise = 0.0;  // of one sigma in every line, in `function`(0)
};

Sums sums_over(const TransferFunction& tf, const Eigen::ArrayXXd& sigma, const Variable& variable,
               long powers) {
  constexpr long chunk = 256;  // lines that stay in the nearest cache
  const auto outputs = static_cast<long>(tf.outputs.size());
  Sums sums{MatrixXcd::Zero(powers, outputs), MatrixXcd::Zero(powers, outputs),
            MatrixXcd::Zero(powers, outputs), VectorXcd::Zero(powers)};
  for (long first = 0; first < tf.lines(); first += chunk) {
    const long n = std::min(chunk, tf.lines() - first);
    const ArrayXd f = tf.frequency_hz.segment(first, n).array();
    const ArrayXd u =
        ((variable.damping == fem::Damping::structural ? f.square() : f) - variable.middle) / variable.half;
    const ArrayXd distance = u.square() + beta * beta;
    const ArrayXd density = 2.0 * beta / distance;  // dtheta/du
    const ArrayXd step_re = (u.square() - beta * beta) / distance, step_im = -2.0 * beta * u / distance;
    Eigen::ArrayXXd basis(n, outputs), cross_re(n, outputs), cross_im(n, outputs);
    ArrayXd function = ArrayXd::Zero(n);
    for (long k = 0; k < outputs; ++k) {
      const auto value = tf.outputs[static_cast<std::size_t>(k)].value.segment(first, n).array();
      const ArrayXd weight = density / sigma.col(k).segment(first, n).square();
      const Eigen::ArrayXcd factor = u.unaryExpr([](double each) { return numerator_factor(each); });
      const Eigen::ArrayXcd cross = weight * factor.conjugate() * value;
      basis.col(k) = weight * factor.abs2();
      cross_re.col(k) = cross.real();
      cross_im.col(k) = cross.imag();
      function += weight * value.abs2();
    }
    sums.noise += 2.0 * static_cast<double>(outputs) * density.sum();
    ArrayXd re = ArrayXd::Ones(n), im = ArrayXd::Zero(n);
    for (long m = 0; m < powers; ++m) {
      sums.function(m) += Complex((function * re).sum(), (function * im).sum());
      for (long k = 0; k < outputs; ++k) {
        sums.basis(m, k) += Complex((basis.col(k) * re).sum(), (basis.col(k) * im).sum());
        const double rr = (cross_re.col(k) * re).sum(), ii = (cross_im.col(k) * im).sum();
        const double ri = (cross_re.col(k) * im).sum(), ir = (cross_im.col(k) * re).sum();
        sums.ahead(m, k) += Complex(rr - ii, ir + ri);
        sums.behind(m, k) += Complex(rr + ii, ir - ri);
      }
      const ArrayXd next = re * step_re - im * step_im;
      im = re * step_im + im * step_re;
      re = next;
    }
  }
  return sums;
}

// One output's numerator basis, factored, and what the function's powers are in it: R = L L^H, V = L^-1 S.
struct Numerator {
  MatrixXcd factor;     // L
  MatrixXcd projected;  // V

  Numerator(const Sums& sums, long k, long rows, long columns) {
    MatrixXcd basis(rows, rows), cross(rows, columns);
    for (long i = 0; i < rows; ++i) {
      for (long j = 0; j <= i; ++j) basis(i, j) = std::conj(sums.basis(i - j, k));
      for (long j = 0; j < columns; ++j) cross(i, j) = j >= i ? sums.ahead(j - i, k) : sums.behind(i - j, k);
      basis(i, i) += rounding * sums.basis(0, k).real();
    }
    factor = Eigen::LLT<MatrixXcd>(basis).matrixL();
    projected = factor.triangularView<Eigen::Lower>().solve(cross);
  }
};

Complex value_of(const VectorXcd& coefficients, Complex z) {
  Complex value = 0.0;
  for (long i = coefficients.size() - 1; i >= 0; --i) value = value * z + coefficients(i);
  return value;
}

// Line nearest to f.
long line_at(const TransferFunction& tf, double f_hz) {
  const auto& f = tf.frequency_hz;
  const long above = std::lower_bound(f.begin(), f.end(), f_hz) - f.begin();
  if (above == 0 || above == f.size()) return std::min(above, f.size() - 1);
  return f_hz - f(above - 1) < f(above) - f_hz ? above - 1 : above;
}

// Sum over the lines of |C g|^2/sigma^2, noise as it is at the resonance: peak^2 (pi/2) bandwidth/spacing.
double gain_of(const TransferFunction& tf, const Eigen::ArrayXXd& sigma, const DenominatorPole& pole,
               fem::Damping damping) {
  const long line = line_at(tf, pole.pole.natural_frequency_hz);
  const double spacing = band_of(tf).spacing_hz;
  const Eigen::ArrayXd peak_over_sigma = pole.modal_constant.array().abs2().sqrt() /
                                         (pole_scale(pole.pole, damping) * sigma.row(line).transpose());
  return peak_over_sigma.square().sum() * 0.5 * std::numbers::pi * bandwidth_hz(pole.pole) / spacing;
}

class Orders {
 public:
  Orders(const TransferFunction& tf, fem::Damping damping, long max_order)
      : tf_(tf), sigma_(floored_sigma(tf)), variable_(tf, damping) {
    const long columns = max_order + 1, rows = columns + extra;
    const Sums sums = sums_over(tf, sigma_, variable_, rows);
    normal_.resize(columns, columns);
    for (long i = 0; i < columns; ++i)
      for (long j = 0; j < columns; ++j)
        normal_(i, j) = j >= i ? sums.function(j - i) : std::conj(sums.function(i - j));
    ridge_ = rounding * sums.function(0).real() + noise_ridge * sums.noise;
    for (long k = 0; k < static_cast<long>(tf.outputs.size()); ++k)
      numerators_.emplace_back(sums, k, rows, columns);
    for (long row = 0; row <= extra; ++row) eliminate(row);
  }

  // Orders must be asked for in turn: each eliminates one numerator power more.
  std::vector<DenominatorPole> poles_of(long order) {
    eliminate(order + extra);
    MatrixXcd normal = normal_.block(1, 1, order, order);
    normal.diagonal().array() += ridge_;
    const Eigen::LLT<MatrixXcd> factor(normal);
    if (factor.info() != Eigen::Success) return {};
    VectorXcd alpha(order + 1);
    alpha(0) = 1.0;
    alpha.tail(order) = factor.solve(-normal_.block(1, 0, order, 1));
    std::vector<VectorXcd> numerator;
    for (const Numerator& each : numerators_) {
      const long rows = order + 1 + extra;
      const VectorXcd projected = each.projected.topLeftCorner(rows, order + 1) * alpha;
      numerator.push_back(
          each.factor.topLeftCorner(rows, rows).triangularView<Eigen::Lower>().adjoint().solve(projected));
    }
    std::vector<DenominatorPole> poles;
    for (const Complex z : roots_inside(alpha)) add_pole(z, alpha, numerator, poles);
    std::sort(poles.begin(), poles.end(), [](const auto& a, const auto& b) {
      return a.pole.natural_frequency_hz < b.pole.natural_frequency_hz;
    });
    return poles;
  }

 private:
  // Roots z of 1 + alpha_1 z + ... within the unit circle: y = 1/z solves y^n + alpha_1 y^(n-1) + ... = 0.
  // Those of the order below, and one more where the band's ends meet, are near them.
  std::vector<Complex> roots_inside(const VectorXcd& alpha) {
    while (static_cast<long>(roots_.size()) < alpha.size() - 1)
      roots_.emplace_back(1.1 + 0.01 * static_cast<double>(roots_.size()), 0.1);
    roots_ = polynomial_roots(alpha.tail(alpha.size() - 1), std::move(roots_));
    std::vector<Complex> inside;
    for (const Complex y : roots_)
      if (std::norm(y) > 1.0) inside.push_back(1.0 / y);
    return inside;
  }

  void eliminate(long row) {
    for (const Numerator& each : numerators_) {
      const auto line = each.projected.row(row);
      normal_.noalias() -= line.adjoint() * line;
    }
  }

  void add_pole(Complex z, const VectorXcd& alpha, const std::vector<VectorXcd>& numerator,
                std::vector<DenominatorPole>& poles) const {
    const Complex u = Complex(0.0, beta) * (1.0 + z) / (1.0 - z);
    const Complex x = variable_.at(u);
    if (!(x.real() > 0.0 && x.imag() > 0.0)) return;
    DenominatorPole found;
    found.pole = variable_.pole(x);
    const double f = found.pole.natural_frequency_hz;
    if (f < tf_.frequency_hz(0) || f > tf_.frequency_hz(tf_.lines() - 1)) return;
    if (!(found.pole.loss_factor < 1.0)) return;
    Complex slope = 0.0;  // dD/dz
    for (long i = alpha.size() - 1; i > 0; --i) slope = slope * z + static_cast<double>(i) * alpha(i);
    const Complex from_centre = u + Complex(0.0, beta);
    slope *= Complex(0.0, 2.0 * beta) / (from_centre * from_centre);  // dz/du
    found.modal_constant.resize(static_cast<long>(numerator.size()));
    for (std::size_t k = 0; k < numerator.size(); ++k)
      found.modal_constant(static_cast<long>(k)) =
          variable_.modal_constant(numerator_factor(u) * value_of(numerator[k], z) / slope);
    found.gain = gain_of(tf_, sigma_, found, variable_.damping);
    poles.push_back(std::move(found));
  }

  const TransferFunction& tf_;
  Eigen::ArrayXXd sigma_;
  Variable variable_;
  MatrixXcd normal_;  // of the denominator's coefficients, numerators eliminated as far as asked for
  double ridge_ = 0.0;
  std::vector<Numerator> numerators_;
  std::vector<Complex> roots_;  // of the last order, y
};

void check(const TransferFunction& tf, int max_order) {
  if (max_order < 1 || max_order > 60)
    throw Error(fmt::format("fit_common_denominator: max_order 1 to 60, got {}", max_order));
  if (tf.outputs.empty()) throw Error("fit_common_denominator: at least one output, got none");
  if (tf.lines() < max_order + 3)
    throw Error(fmt::format("fit_common_denominator: at least max_order + 3 = {} lines, got {}",
                            max_order + 3, tf.lines()));
  for (const auto& output : tf.outputs)
    if (output.sigma.size() != tf.lines() || !(output.sigma.minCoeff() > 0.0))
      throw Error(fmt::format("fit_common_denominator: a positive sigma on every line of {}", output.name));
}

}  // namespace

std::vector<std::vector<DenominatorPole>> fit_common_denominator(const TransferFunction& tf,
                                                                 fem::Damping damping, int max_order) {
  check(tf, max_order);
  Orders orders(tf, damping, max_order);
  std::vector<std::vector<DenominatorPole>> poles;
  for (long order = 1; order <= max_order; ++order) poles.push_back(orders.poles_of(order));
  return poles;
}

}  // namespace struna::ident
