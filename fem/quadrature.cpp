#include "fem/quadrature.hpp"

#include <cmath>
#include <numbers>

namespace struna::fem {
namespace {

struct Legendre {
  double value;
  double slope;
};

Legendre legendre(int degree, double x) {
  double previous = 1.0;
  double current = x;
  for (int k = 2; k <= degree; ++k) {
    const double next = ((2 * k - 1) * x * current - (k - 1) * previous) / k;
    previous = current;
    current = next;
  }
  return {current, degree * (x * current - previous) / (x * x - 1.0)};
}

/// Value at x of the Lagrange polynomial that is 1 at node `index`.
double lagrange(const Eigen::VectorXd& nodes, long index, double x) {
  double value = 1.0;
  for (long k = 0; k < nodes.size(); ++k) {
    if (k != index) value *= (x - nodes(k)) / (nodes(index) - nodes(k));
  }
  return value;
}

}  // namespace

GaussRule gauss_legendre(int points) {
  GaussRule rule{Eigen::VectorXd(points), Eigen::VectorXd(points)};
  for (int i = 0; i < points; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (points + 0.5));
    for (int iteration = 0; iteration < 8; ++iteration) {
      const Legendre p = legendre(points, x);
      x -= p.value / p.slope;
    }
    const double slope = legendre(points, x).slope;
    rule.node(i) = 0.5 * (1.0 + x);
    rule.weight(i) = 1.0 / ((1.0 - x * x) * slope * slope);
  }
  return rule;
}

Eigen::MatrixXd integration_matrix(const Eigen::VectorXd& nodes) {
  const long n = nodes.size();
  const GaussRule inner = gauss_legendre(static_cast<int>(n));
  Eigen::MatrixXd matrix(n, n);
  for (long i = 0; i < n; ++i) {
    for (long j = 0; j < n; ++j) {
      double integral = 0.0;
      for (long k = 0; k < n; ++k) integral += inner.weight(k) * lagrange(nodes, j, nodes(i) * inner.node(k));
      matrix(i, j) = nodes(i) * integral;
    }
  }
  return matrix;
}

}  // namespace struna::fem
