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

/// Lines that follow every resonance in the band and what is between them, increasing [Hz].
Eigen::VectorXd band_lines(const ModalBody& body, const FrequencyLaw& loss_factor, double lo_hz,
                           double hi_hz) {
  constexpr long spread = 200;  // over the band
  constexpr int half = 10;      // on each side of a resonance, over 6 of its half-power bandwidths
  if (!(hi_hz > lo_hz)) return Eigen::VectorXd::Constant(1, lo_hz);
  std::vector<double> lines;
  // In equal ratios: a motion of flat acceleration is largest at the band's lower end.
  for (long k = 0; k < spread; ++k)
    lines.push_back(lo_hz * std::pow(hi_hz / lo_hz, static_cast<double>(k) / (spread - 1)));
  for (const double f : body.poles.natural_frequency_hz) {
    if (!(f > lo_hz && f < hi_hz)) continue;
    const double width = loss_factor.at(f) * f;
    for (int k = -half; k <= half; ++k) {
      const double line = f + 6.0 * width * std::pow(static_cast<double>(k) / half, 3);
      if (line > lo_hz && line < hi_hz) lines.push_back(line);
    }
  }
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  return Eigen::Map<const Eigen::VectorXd>(lines.data(), static_cast<long>(lines.size()));
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

double rms_distance(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b, const Eigen::VectorXd& drive,
                    const Eigen::VectorXd& frequency_hz) {
  const long lines = frequency_hz.size();
  double off = 0.0, all = 0.0;
  for (long i = 0; i < lines; ++i) {
    // The trapezoidal rule's share of the line.
    const double share =
        lines == 1 ? 1.0 : frequency_hz[std::min(i + 1, lines - 1)] - frequency_hz[std::max(i - 1, 0L)];
    off += share * drive[i] * drive[i] * (a.row(i) - b.row(i)).squaredNorm();
    all += share * drive[i] * drive[i] * b.row(i).squaredNorm();
  }
  return all > 0.0 ? std::sqrt(off / all) : 0.0;
}

std::optional<double> causal_distance(const Scene& scene, const Model& measured, const ModalBody& body,
                                      const std::vector<OutputRow>& rows, double lo_hz, double hi_hz) {
  const Material& material = measured.body.material;
  if (material.damping != Damping::structural || is_lossless(material.loss_factor) ||
      !is_on_linear_path(scene, measured.body.name))
    return std::nullopt;
  const Eigen::VectorXd frequency_hz = band_lines(body, material.loss_factor, lo_hz, hi_hz);
  const LinearPath path = linear_path(scene);
  Eigen::MatrixXcd harmonic =
      harmonic_response(measured, path.drive, path.measurement, frequency_hz, {Damping::structural, false})
          .response;
  for (long i = 0; i < frequency_hz.size(); ++i) {
    harmonic.row(i) *= derivative_factor(*scene.measurement, frequency_hz[i]);
  }
  const bool force = std::holds_alternative<BodyPoint>(scene.drive->at);
  const Eigen::VectorXd drive = force ? Eigen::VectorXd(Eigen::VectorXd::Ones(frequency_hz.size()))
                                      : Eigen::VectorXd(frequency_hz.array().square().inverse());
  return rms_distance(pole_response(body, rows, frequency_hz), harmonic, drive, frequency_hz);
}

}  // namespace struna::fem
