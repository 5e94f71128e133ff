#include "fem/causal_distance.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fem/harmonic.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;

Complex laplace(double f_hz) {
  return {0.0, 2.0 * std::numbers::pi * f_hz};
}

/// What the harmonic response has to be multiplied by: it knows displacements only.
Complex derivative_factor(const SceneMeasurement& measurement, double f_hz) {
  if (std::holds_alternative<Support>(measurement.at)) return 1.0;
  switch (measurement.quantity) {
    case MotionQuantity::displacement:
      return 1.0;
    case MotionQuantity::velocity:
      return laplace(f_hz);
    case MotionQuantity::acceleration:
      break;
  }
  return laplace(f_hz) * laplace(f_hz);
}

bool is_lossless(const FrequencyLaw& loss_factor) {
  return loss_factor.kind == FrequencyLaw::Kind::constant && loss_factor.at(1.0) == 0.0;
}

}  // namespace

Eigen::MatrixXcd pole_response(const ModalBody& body, const std::vector<OutputRow>& rows,
                               const Eigen::VectorXd& frequency_hz) {
  Eigen::MatrixXcd response(frequency_hz.size(), static_cast<long>(rows.size()));
  for (long line = 0; line < frequency_hz.size(); ++line) {
    const Complex s = laplace(frequency_hz[line]);
    const Eigen::Vector3cd motion(1.0, s, s * s);
    Eigen::VectorXcd x = body.load.cast<Complex>() * motion;
    for (int m = 0; m < body.poles.modes; ++m) x[m] *= modal_receptance(body.poles, m, frequency_hz[line]);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const OutputRow& row = rows[k];
      const Eigen::VectorXcd weight = row.on_displacement.cast<Complex>() +
                                      s * row.on_velocity.cast<Complex>() +
                                      s * s * row.on_acceleration.cast<Complex>();
      response(line, static_cast<long>(k)) = weight.cwiseProduct(x).sum() +
                                             row.on_motion.cast<Complex>().dot(motion) +
                                             row.static_stiffness * body.poles.law.at(s);
    }
  }
  return response;
}

double median_distance(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b) {
  const double largest = b.size() > 0 ? b.colwise().norm().maxCoeff() : 0.0;
  std::vector<double> errors;
  for (long k = 0; k < b.cols(); ++k) {
    if (!(b.col(k).norm() > 1e-6 * largest)) continue;
    for (long i = 0; i < b.rows(); ++i) errors.push_back(std::abs(a(i, k) / b(i, k) - 1.0));
  }
  if (errors.empty()) return 0.0;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

std::optional<double> causal_distance(const Scene& scene, const Model& measured, const ModalBody& body,
                                      const std::vector<OutputRow>& rows, double lo_hz, double hi_hz) {
  const Material& material = measured.body.material;
  if (material.damping != Damping::structural || is_lossless(material.loss_factor) ||
      !is_on_linear_path(scene, measured.body.name))
    return std::nullopt;
  constexpr long lines = 200;
  const Eigen::VectorXd frequency_hz = Eigen::VectorXd::LinSpaced(hi_hz > lo_hz ? lines : 1, lo_hz, hi_hz);
  const LinearPath path = linear_path(scene);
  Eigen::MatrixXcd harmonic =
      harmonic_response(measured, path.drive, path.measurement, frequency_hz, {Damping::structural, false})
          .response;
  for (long i = 0; i < frequency_hz.size(); ++i) {
    harmonic.row(i) *= derivative_factor(*scene.measurement, frequency_hz[i]);
  }
  return median_distance(pole_response(body, rows, frequency_hz), harmonic);
}

}  // namespace struna::fem
