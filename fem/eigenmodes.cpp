#include "fem/eigenmodes.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "fem/band_cholesky.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// The sign that makes the largest component positive: the same shape on every machine.
double orientation(const Eigen::VectorXd& shape) {
  Eigen::Index largest = 0;
  shape.cwiseAbs().maxCoeff(&largest);
  return shape(largest) < 0.0 ? -1.0 : 1.0;
}

/// Eigenpairs over the free dof.
struct Pairs {
  Eigen::VectorXd value;
  Eigen::MatrixXd vector;
};

Pairs solve_dense(const BandMatrix& stiffness, const BandMatrix& mass, const std::string& name) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness.dense(), mass.dense());
  if (solver.info() != Eigen::Success) {
    throw Error(fmt::format("solve_eigenmodes: no convergence for body '{}'", name));
  }
  return {solver.eigenvalues(), solver.eigenvectors()};
}

/// The lowest `count` pairs by subspace iteration (Bathe, Finite Element Procedures, section 11.6) on K +
/// shift M, which is definite also for a body that is not held. A block of vectors finds double eigenvalues,
/// of which a straight body has many, and the reduced stiffness Y^T (K + shift M) Y comes without the
/// cancellation of a product with K. Nothing when it does not settle.
std::optional<Pairs> solve_subspace(const BandMatrix& stiffness, const BandMatrix& mass, double shift,
                                    long count, long block) {
  BandCholesky factor;
  if (!factor.factorise(stiffness, 1.0, mass, shift)) return std::nullopt;
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd load = Eigen::MatrixXd::NullaryExpr(mass.size(), block, [&] { return uniform(generator); });
  Eigen::VectorXd previous = Eigen::VectorXd::Zero(count);
  double last_change = 1.0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    Eigen::MatrixXd y = load;
    for (long c = 0; c < block; ++c) factor.solve(y.col(c));
    const Eigen::MatrixXd mass_y = multiply(mass, y);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> reduced(y.transpose() * load,
                                                                            y.transpose() * mass_y);
    if (reduced.info() != Eigen::Success) return std::nullopt;
    const Eigen::VectorXd value = reduced.eigenvalues().head(count);
    load = mass_y * reduced.eigenvectors();
    // Every round is worth two digits until rounding, which grows as the fourth power of the elements, ends
    // it.
    const double change = ((value - previous).array() / value.array()).abs().maxCoeff();
    const bool settled = change <= 1e-13 || (change < 1e-8 && change > 0.5 * last_change);
    last_change = change;
    previous = value;
    if (settled) {
      return Pairs{value.array() - shift, y * reduced.eigenvectors().leftCols(count)};
    }
  }
  return std::nullopt;
}

}  // namespace

Eigenmodes solve_eigenmodes(const Model& model, int count) {
  if (model.free_dof.empty()) {
    throw Error(
        fmt::format("solve_eigenmodes: body '{}' has no free dof; use more elements", model.body.name));
  }
  const BandMatrix stiffness = submatrix(model.stiffness, model.free_dof);
  const BandMatrix mass = submatrix(model.mass, model.free_dof);
  const long free = static_cast<long>(model.free_dof.size());
  const long modes = count <= 0 ? free : std::min<long>(count, free);
  // Twice the modes wanted, so that lambda ~ mode^4 makes every round worth two digits; worth it on fine
  // meshes only.
  const long block = 2 * modes + 8;
  std::optional<Pairs> pairs;
  if (4 * block < free) pairs = solve_subspace(stiffness, mass, clamped_eigenvalue(model.body), modes, block);
  if (!pairs) pairs = solve_dense(stiffness, mass, model.body.name);
  Eigenmodes result{pairs->value.head(modes), Eigen::MatrixXd::Zero(model.dof_count(), modes)};
  for (long r = 0; r < modes; ++r) {
    const Eigen::VectorXd shape = pairs->vector.col(r);
    const double sign = orientation(shape);
    for (long i = 0; i < free; ++i) result.shape(model.free_dof[i], r) = sign * shape(i);
  }
  return result;
}

double clamped_eigenvalue(const Body& body) {
  const double length2 = body.centreline.length() * body.centreline.length();
  return std::pow(4.730040744862704, 4) * body.section.second_moment /
         (body.density * body.section.area * length2 * length2);
}

bool is_rigid(const Body& body, double eigenvalue) {
  return eigenvalue < 1e-4 * clamped_eigenvalue(body);
}

long rigid_modes(const Body& body, const Eigen::VectorXd& eigenvalue) {
  long count = 0;
  while (count < eigenvalue.size() && is_rigid(body, eigenvalue(count))) ++count;
  return count;
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

Eigen::VectorXd natural_frequencies_hz(const Body& body, const Eigen::VectorXd& eigenvalue) {
  return eigenvalue.unaryExpr([&](double lambda) {
    return is_rigid(body, lambda) ? 0.0 : natural_frequency_hz(lambda, body.material.youngs_modulus);
  });
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
