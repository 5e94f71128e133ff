#include "ident/single_dof.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

Eigen::VectorXd weights(const TransferFunction& tf, StiffnessWeight weight) {
  const auto& output = tf.outputs[0];
  if (weight == StiffnessWeight::sigma) {
    if (output.sigma.size() == 0)
      throw Error(
          "fit_single_dof_stiffness: weighing by sigma needs a sigma column, and there is none: weigh "
          "otherwise");
    if (!(output.sigma.minCoeff() > 0.0))
      throw Error("fit_single_dof_stiffness: weighing by sigma needs every sigma above 0");
    return output.sigma.cwiseInverse();
  }
  Eigen::VectorXd result = output.value.cwiseAbs().cwiseInverse();
  if (weight == StiffnessWeight::integrated) result.array() /= tf.frequency_hz.array().square();
  if (!result.allFinite())
    throw Error("fit_single_dof_stiffness: a line at 0 Hz or of value 0 has no finite weight: leave it out");
  return result;
}

void check(const TransferFunction& tf) {
  if (tf.outputs.size() != 1 || tf.outputs[0].kind != FrfKind::dynamic_stiffness)
    throw Error(fmt::format(
        "fit_single_dof_stiffness: one dynamic stiffness is needed, got {} output(s), the first of kind {}",
        tf.outputs.size(), tf.outputs.empty() ? "none" : to_string(tf.outputs[0].kind)));
  if (tf.lines() < 3)
    throw Error(fmt::format("fit_single_dof_stiffness: at least 3 lines, got {}", tf.lines()));
}

}  // namespace

SingleDof fit_single_dof_stiffness(const TransferFunction& tf, StiffnessWeight weight) {
  check(tf);
  const Eigen::VectorXd w = weights(tf, weight);
  const long lines = tf.lines();
  // Real parts above imaginary parts; columns 1, s, s^2.
  Eigen::MatrixXd basis(2 * lines, 3);
  Eigen::VectorXd value(2 * lines);
  for (long i = 0; i < lines; ++i) {
    const std::complex<double> s(tf.exponential_decay, 2.0 * std::numbers::pi * tf.frequency_hz[i]);
    const std::complex<double> power[] = {1.0, s, s * s};
    for (long j = 0; j < 3; ++j) {
      basis(i, j) = w[i] * power[j].real();
      basis(lines + i, j) = w[i] * power[j].imag();
    }
    value[i] = w[i] * tf.outputs[0].value[i].real();
    value[lines + i] = w[i] * tf.outputs[0].value[i].imag();
  }
  // Columns scaled to unit length: k, c and m differ by powers of omega.
  const Eigen::RowVector3d scale = basis.colwise().norm();
  basis.array().rowwise() /= scale.array();
  const Eigen::LDLT<Eigen::Matrix3d> normal(basis.transpose() * basis);
  const Eigen::Vector3d scaled = normal.solve(basis.transpose() * value);
  const double left = (value - basis * scaled).squaredNorm();
  const double variance = weight == StiffnessWeight::sigma ? 1.0 : left / static_cast<double>(2 * lines - 3);
  const Eigen::Matrix3d covariance = variance * normal.solve(Eigen::Matrix3d::Identity());
  const auto error = [&](long j) { return std::sqrt(covariance(j, j)) / scale[j]; };

  SingleDof fit;
  fit.stiffness = scaled[0] / scale[0];
  fit.damping = scaled[1] / scale[1];
  fit.mass = scaled[2] / scale[2];
  fit.stiffness_sigma = error(0);
  fit.damping_sigma = error(1);
  fit.mass_sigma = error(2);
  fit.scatter = std::sqrt(left / value.squaredNorm());
  const double none = std::numeric_limits<double>::quiet_NaN();
  fit.natural_frequency_hz =
      fit.physical() ? std::sqrt(fit.stiffness / fit.mass) / (2.0 * std::numbers::pi) : none;
  fit.damping_ratio = fit.physical() ? fit.damping / (2.0 * std::sqrt(fit.stiffness * fit.mass)) : none;
  return fit;
}

}  // namespace struna::ident
