#include "ident/polynomial_roots.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr int most_sweeps = 40;
constexpr double settled = 1e-9;  // last step over the root; convergence is cubic, so the error is rounding

// Without the check for infinities of the standard operator, which costs more than the product.
struct Plain {
  double re;
  double im;
  Plain operator+(Plain b) const { return {re + b.re, im + b.im}; }
  Plain operator-(Plain b) const { return {re - b.re, im - b.im}; }
  Plain operator*(Plain b) const { return {re * b.re - im * b.im, re * b.im + im * b.re}; }
  double square() const { return re * re + im * im; }
  Plain inverse() const {
    const double scale = 1.0 / square();
    return {re * scale, -im * scale};
  }
};

std::vector<std::complex<double>> companion_eigenvalues(const Eigen::VectorXcd& c) {
  const long n = c.size();
  Eigen::MatrixXcd companion = Eigen::MatrixXcd::Zero(n, n);
  companion.row(0) = -c.transpose();
  for (long i = 1; i < n; ++i) companion(i, i - 1) = 1.0;
  Eigen::ComplexSchur<Eigen::MatrixXcd> schur(n);
  schur.computeFromHessenberg(companion, companion, false);
  if (schur.info() != Eigen::Success) return {};
  const Eigen::VectorXcd roots = schur.matrixT().diagonal();
  return {roots.begin(), roots.end()};
}

}  // namespace

std::vector<std::complex<double>> polynomial_roots(const Eigen::VectorXcd& c,
                                                   std::vector<std::complex<double>> start) {
  const auto n = static_cast<std::size_t>(c.size());
  if (start.size() != n)
    throw Error(fmt::format("polynomial_roots: a start for each of {} roots, got {}", n, start.size()));
  if (n == 0 || !c.allFinite()) return {};
  std::vector<Plain> coefficient, root;
  for (const auto& value : c) coefficient.push_back({value.real(), value.imag()});
  for (const auto& value : start) root.push_back({value.real(), value.imag()});
  std::vector<bool> done(n, false);
  std::size_t open = n;
  for (int sweep = 0; sweep < most_sweeps && open > 0; ++sweep) {
    for (std::size_t i = 0; i < n; ++i) {
      if (done[i]) continue;
      const Plain y = root[i];
      Plain value{1.0, 0.0}, slope{0.0, 0.0};
      for (const Plain& each : coefficient) {
        slope = slope * y + value;
        value = value * y + each;
      }
      Plain repulsion{0.0, 0.0};
      for (std::size_t j = 0; j < n; ++j)
        if (j != i) repulsion = repulsion + (y - root[j]).inverse();
      const Plain step = value * (slope - value * repulsion).inverse();
      root[i] = y - step;
      if (!(step.square() > settled * settled * root[i].square())) {
        done[i] = true;
        --open;
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) start[i] = {root[i].re, root[i].im};
  const bool finite =
      std::all_of(root.begin(), root.end(), [](const Plain& y) { return y.square() < 1e300; });
  return open == 0 && finite ? start : companion_eigenvalues(c);
}

}  // namespace struna::ident
