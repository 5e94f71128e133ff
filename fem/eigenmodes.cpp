#include "fem/eigenmodes.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// The sign that makes the largest component positive: the same shape on every machine.
double orientation(const Eigen::VectorXd& shape) {
  Eigen::Index largest = 0;
  shape.cwiseAbs().maxCoeff(&largest);
  return shape(largest) < 0.0 ? -1.0 : 1.0;
}

}  // namespace

Eigenmodes solve_eigenmodes(const Model& model, int count) {
  if (model.free_dof.empty()) {
    throw Error(
        fmt::format("solve_eigenmodes: body '{}' has no free dof; use more elements", model.body.name));
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      submatrix(model.stiffness, model.free_dof).dense(), submatrix(model.mass, model.free_dof).dense());
  if (solver.info() != Eigen::Success) {
    throw Error(fmt::format("solve_eigenmodes: no convergence for body '{}'", model.body.name));
  }
  const long free = static_cast<long>(model.free_dof.size());
  const long modes = count <= 0 ? free : std::min<long>(count, free);
  Eigenmodes result{solver.eigenvalues().head(modes), Eigen::MatrixXd::Zero(model.dof_count(), modes)};
  for (long r = 0; r < modes; ++r) {
    const Eigen::VectorXd shape = solver.eigenvectors().col(r);
    const double sign = orientation(shape);
    for (long i = 0; i < free; ++i) result.shape(model.free_dof[i], r) = sign * shape(i);
  }
  return result;
}

double natural_frequency_hz(double eigenvalue, const FrequencyLaw& youngs_modulus) {
  if (!(eigenvalue > 0.0)) return 0.0;
  // Root of g(x) = 2 ln(2 pi e^x) - ln E(e^x) - ln lambda in x = ln f: Newton with slope 2 - n, n = d ln E/d
  // ln f, kept inside a bracket that is widened first.
  const auto excess = [&](double x) {
    return 2.0 * (std::log(2.0 * std::numbers::pi) + x) - std::log(youngs_modulus.at(std::exp(x))) -
           std::log(eigenvalue);
  };
  double x = 0.5 * std::log(youngs_modulus.at(1.0) * eigenvalue) - std::log(2.0 * std::numbers::pi);
  double low = x;
  double high = x;
  for (double step = 0.5; excess(low) > 0.0 && step < 200.0; step *= 2.0) low -= step;
  for (double step = 0.5; excess(high) < 0.0 && step < 200.0; step *= 2.0) high += step;
  if (!(excess(low) <= 0.0 && excess(high) >= 0.0)) {
    throw Error(
        "natural_frequency_hz: the modulus must rise slower than f^2, or no natural frequency exists");
  }
  for (int iteration = 0; iteration < 200; ++iteration) {
    const double g = excess(x);
    if (std::abs(g) < 2e-15) break;
    (g > 0.0 ? high : low) = x;
    const double newton = x - g / (2.0 - youngs_modulus.log_slope(std::exp(x)));
    const double next = newton >= low && newton <= high ? newton : 0.5 * (low + high);
    if (next == x) break;
    x = next;
  }
  return std::exp(x);
}

double modulus_from_frequency(double f_hz, double eigenvalue) {
  if (!(f_hz > 0.0 && eigenvalue > 0.0)) {
    throw Error(
        fmt::format("modulus_from_frequency: frequency and eigenvalue must be positive, got {:g} Hz and {:g}",
                    f_hz, eigenvalue));
  }
  const double omega = 2.0 * std::numbers::pi * f_hz;
  return omega * omega / eigenvalue;
}

}  // namespace struna::fem
