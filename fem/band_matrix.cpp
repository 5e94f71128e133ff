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

Eigen::VectorXd multiply_sparse(const BandMatrix& a, const Eigen::VectorXd& x) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
  for (int j = 0; j < a.size(); ++j) {
    if (x(j) == 0.0) continue;
    const int last = std::min(j + a.half_bandwidth(), a.size() - 1);
    for (int i = std::max(0, j - a.half_bandwidth()); i <= last; ++i) y(i) += a.at(i, j) * x(j);
  }
  return y;
}

namespace {

template <int lanes>
struct Complex {
  using Lane = Eigen::Array<double, lanes, 1>;
  Lane re;
  Lane im;

  Complex() = default;
  Complex(const Lane& real, const Lane& imaginary) : re(real), im(imaginary) {}
  explicit Complex(const std::array<std::complex<double>, lanes>& scales) {
    for (int lane = 0; lane < lanes; ++lane) {
      re(lane) = scales[static_cast<std::size_t>(lane)].real();
      im(lane) = scales[static_cast<std::size_t>(lane)].imag();
    }
  }
  /// Entry i of a vector.
  template <class Vectors>
  Complex(const Vectors& v, long i) : re(v.re.col(i)), im(v.im.col(i)) {}

  template <class Vectors>
  void store(Vectors& v, long i) const {
    v.re.col(i) = re;
    v.im.col(i) = im;
  }
};

template <int lanes>
Complex<lanes> operator*(const Complex<lanes>& a, const Complex<lanes>& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

/// v(target + i) -= a b(source + i), i = 0..count - 1; the two ranges are apart.
template <int lanes, class Vectors>
void subtract_multiple(Vectors& v, long target, const Complex<lanes>& a, const Vectors& b, long source,
                       long count) {
  if constexpr (lanes == 1) {
    const auto re = b.re.middleCols(source, count);
    const auto im = b.im.middleCols(source, count);
    v.re.middleCols(target, count) -= a.re(0) * re - a.im(0) * im;
    v.im.middleCols(target, count) -= a.re(0) * im + a.im(0) * re;
  } else {
    for (long i = 0; i < count; ++i) {
      v.re.col(target + i) -= a.re * b.re.col(source + i) - a.im * b.im.col(source + i);
      v.im.col(target + i) -= a.re * b.im.col(source + i) + a.im * b.re.col(source + i);
    }
  }
}

/// Sum of a(first + i) b(second + i), i = 0..count - 1.
template <int lanes, class Vectors>
Complex<lanes> product_sum(const Vectors& a, long first, const Vectors& b, long second, long count) {
  Complex<lanes> sum(Complex<lanes>::Lane::Zero(), Complex<lanes>::Lane::Zero());
  for (long i = 0; i < count; ++i) {
    sum.re += a.re.col(first + i) * b.re.col(second + i) - a.im.col(first + i) * b.im.col(second + i);
    sum.im += a.re.col(first + i) * b.im.col(second + i) + a.im.col(first + i) * b.re.col(second + i);
  }
  return sum;
}

}  // namespace

template <int lanes>
ComplexBandSolver<lanes>::ComplexBandSolver(const BandMatrix& stiffness, const BandMatrix& mass)
    : stiffness_(stiffness), mass_(mass) {
  const long n = stiffness.lower.cols();
  const long height = stiffness.lower.rows();
  factor_ = {Lanes(lanes, n * height), Lanes(lanes, n * height)};
  inverse_ = {Lanes(lanes, n), Lanes(lanes, n)};
}

template <int lanes>
int ComplexBandSolver<lanes>::factorise(const Scales& stiffness_scale, const Scales& mass_scale) {
  stiffness_scale_ = stiffness_scale;
  mass_scale_ = mass_scale;
  const Complex<lanes> s_k(stiffness_scale);
  const Complex<lanes> s_m(mass_scale);
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
    const Complex<lanes> pivot(factor_, column);
    const auto size = (pivot.re.square() + pivot.im.square()).eval();
    for (int lane = 0; lane < lanes; ++lane) {
      if (!(size(lane) > 0.0) || !std::isfinite(size(lane))) return lane;
    }
    const Complex<lanes> inverse(pivot.re / size, -pivot.im / size);
    inverse.store(inverse_, j);
    const long below = std::min(height - 1, n - 1 - j);
    for (long k = 1; k <= below; ++k) {
      const Complex<lanes> l = Complex<lanes>(factor_, column + k) * inverse;
      subtract_multiple(factor_, (j + k) * height, l, factor_, column + k, below - k + 1);
      // Entries above k in this column are not needed unscaled any more.
      l.store(factor_, column + k);
    }
  }
  return -1;
}

template <int lanes>
void ComplexBandSolver<lanes>::substitute(Vectors& b) const {
  const long n = stiffness_.lower.cols();
  const long height = stiffness_.lower.rows();
  for (long j = 0; j < n; ++j) {
    const Complex<lanes> value(b, j);
    subtract_multiple(b, j + 1, value, factor_, j * height + 1, std::min(height - 1, n - 1 - j));
    (value * Complex<lanes>(inverse_, j)).store(b, j);
  }
  for (long j = n - 1; j >= 0; --j) {
    const Complex<lanes> known =
        product_sum<lanes>(factor_, j * height + 1, b, j + 1, std::min(height - 1, n - 1 - j));
    b.re.col(j) -= known.re;
    b.im.col(j) -= known.im;
  }
}

template <int lanes>
typename ComplexBandSolver<lanes>::Vectors ComplexBandSolver<lanes>::residual(const Vectors& b,
                                                                              const Vectors& x) const {
  const Complex<lanes> s_k(stiffness_scale_);
  const Complex<lanes> s_m(mass_scale_);
  const long n = stiffness_.lower.cols();
  const long height = stiffness_.lower.rows();
  Vectors r = b;
  Vectors column{Lanes(lanes, height), Lanes(lanes, height)};
  for (long j = 0; j < n; ++j) {
    const long below = std::min(height - 1, n - 1 - j);
    for (long k = 0; k <= below; ++k) {
      column.re.col(k) = s_k.re * stiffness_.lower(k, j) + s_m.re * mass_.lower(k, j);
      column.im.col(k) = s_k.im * stiffness_.lower(k, j) + s_m.im * mass_.lower(k, j);
    }
    subtract_multiple(r, j, Complex<lanes>(x, j), column, 0, below + 1);
    const Complex<lanes> above = product_sum<lanes>(column, 1, x, j + 1, below);
    r.re.col(j) -= above.re;
    r.im.col(j) -= above.im;
  }
  return r;
}

template <int lanes>
void ComplexBandSolver<lanes>::solve(Vectors& b, bool refine) const {
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

template class ComplexBandSolver<1>;
template class ComplexBandSolver<4>;

}  // namespace struna::fem
