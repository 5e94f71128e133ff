#include "fem/band_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace struna::fem {

double BandMatrix::at(int i, int j) const {
  const int distance = std::abs(i - j);
  return distance > half_bandwidth() ? 0.0 : lower(distance, std::min(i, j));
}

Eigen::MatrixXd BandMatrix::dense() const {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(size(), size());
  for (int j = 0; j < size(); ++j) {
    for (int k = 0; k <= half_bandwidth() && j + k < size(); ++k) a(j + k, j) = a(j, j + k) = lower(k, j);
  }
  return a;
}

Eigen::MatrixXd multiply(const BandMatrix& a, const Eigen::MatrixXd& x) {
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(x.rows(), x.cols());
  for (long column = 0; column < x.cols(); ++column) {
    for (int j = 0; j < a.size(); ++j) {
      const int below = std::min(a.half_bandwidth(), a.size() - 1 - j);
      const auto entries = a.lower.col(j).segment(1, below);
      y(j, column) += a.lower(0, j) * x(j, column) + entries.dot(x.col(column).segment(j + 1, below));
      y.col(column).segment(j + 1, below) += x(j, column) * entries;
    }
  }
  return y;
}

BandMatrix submatrix(const BandMatrix& a, const std::vector<int>& dof) {
  const long n = static_cast<long>(dof.size());
  BandMatrix part{Eigen::MatrixXd::Zero(a.lower.rows(), n)};
  for (long j = 0; j < n; ++j) {
    for (long k = 0; k < a.lower.rows() && j + k < n; ++k) part.lower(k, j) = a.at(dof[j + k], dof[j]);
  }
  return part;
}

namespace {

using Lane = Eigen::Array<double, ComplexBandSolver::lanes, 1>;

struct Complex {
  Lane re;
  Lane im;
};

Complex load(const ComplexBandSolver::Vectors& v, long i) {
  return {v.re.col(i), v.im.col(i)};
}

/// v(i) -= a b.
void subtract_product(ComplexBandSolver::Vectors& v, long i, const Complex& a, const Complex& b) {
  v.re.col(i) -= a.re * b.re - a.im * b.im;
  v.im.col(i) -= a.re * b.im + a.im * b.re;
}

Complex product(const Complex& a, const Complex& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

void store(ComplexBandSolver::Vectors& v, long i, const Complex& value) {
  v.re.col(i) = value.re;
  v.im.col(i) = value.im;
}

Complex scale(const ComplexBandSolver::Scales& scales) {
  Complex s;
  for (int lane = 0; lane < ComplexBandSolver::lanes; ++lane) {
    s.re(lane) = scales[static_cast<std::size_t>(lane)].real();
    s.im(lane) = scales[static_cast<std::size_t>(lane)].imag();
  }
  return s;
}

}  // namespace

ComplexBandSolver::ComplexBandSolver(const BandMatrix& stiffness, const BandMatrix& mass)
    : stiffness_(stiffness), mass_(mass) {
  const long n = stiffness.lower.cols();
  const long height = stiffness.lower.rows();
  factor_ = {Lanes::Zero(lanes, n * height), Lanes::Zero(lanes, n * height)};
  inverse_ = {Lanes::Zero(lanes, n), Lanes::Zero(lanes, n)};
}

int ComplexBandSolver::factorise(const Scales& stiffness_scale, const Scales& mass_scale) {
  stiffness_scale_ = stiffness_scale;
  mass_scale_ = mass_scale;
  const Complex s_k = scale(stiffness_scale);
  const Complex s_m = scale(mass_scale);
  const long entries = stiffness_.lower.size();
  for (long i = 0; i < entries; ++i) {
    const double k = stiffness_.lower.data()[i];
    const double m = mass_.lower.data()[i];
    factor_.re.col(i) = s_k.re * k + s_m.re * m;
    factor_.im.col(i) = s_k.im * k + s_m.im * m;
  }
  const long n = stiffness_.lower.cols();
  const long height = stiffness_.lower.rows();
  for (long j = 0; j < n; ++j) {
    const long column = j * height;
    const Complex pivot = load(factor_, column);
    const Lane size = pivot.re.square() + pivot.im.square();
    for (int lane = 0; lane < lanes; ++lane) {
      if (!(size(lane) > 0.0) || !std::isfinite(size(lane))) return lane;
    }
    const Complex inverse{pivot.re / size, -pivot.im / size};
    store(inverse_, j, inverse);
    const long below = std::min(height - 1, n - 1 - j);
    for (long k = 1; k <= below; ++k) {
      const Complex l = product(load(factor_, column + k), inverse);
      const long target = (j + k) * height - k;
      for (long i = k; i <= below; ++i) subtract_product(factor_, target + i, l, load(factor_, column + i));
      // Entries above k in this column are not needed unscaled any more.
      store(factor_, column + k, l);
    }
  }
  return -1;
}

void ComplexBandSolver::substitute(Vectors& b) const {
  const long n = stiffness_.lower.cols();
  const long height = stiffness_.lower.rows();
  for (long j = 0; j < n; ++j) {
    const Complex value = load(b, j);
    const long below = std::min(height - 1, n - 1 - j);
    for (long k = 1; k <= below; ++k) subtract_product(b, j + k, load(factor_, j * height + k), value);
    store(b, j, product(value, load(inverse_, j)));
  }
  for (long j = n - 1; j >= 0; --j) {
    const long below = std::min(height - 1, n - 1 - j);
    for (long k = 1; k <= below; ++k) subtract_product(b, j, load(factor_, j * height + k), load(b, j + k));
  }
}

ComplexBandSolver::Vectors ComplexBandSolver::residual(const Vectors& b, const Vectors& x) const {
  const Complex s_k = scale(stiffness_scale_);
  const Complex s_m = scale(mass_scale_);
  const long n = stiffness_.lower.cols();
  const long height = stiffness_.lower.rows();
  Vectors r = b;
  for (long j = 0; j < n; ++j) {
    const Complex x_j = load(x, j);
    for (long k = 0; k < height && j + k < n; ++k) {
      const double stiffness = stiffness_.lower(k, j);
      const double mass = mass_.lower(k, j);
      const Complex a{s_k.re * stiffness + s_m.re * mass, s_k.im * stiffness + s_m.im * mass};
      subtract_product(r, j + k, a, x_j);
      if (k > 0) subtract_product(r, j, a, load(x, j + k));
    }
  }
  return r;
}

void ComplexBandSolver::solve(Vectors& b, bool refine) const {
  Vectors x = b;
  substitute(x);
  if (refine) {
    Vectors correction = residual(b, x);
    substitute(correction);
    x.re += correction.re;
    x.im += correction.im;
  }
  b = std::move(x);
}

}  // namespace struna::fem
