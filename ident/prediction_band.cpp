#include "ident/prediction_band.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

namespace struna::ident {
namespace {

constexpr double part = 0.01;  // of a standard error: resonances shift by far less than their width

/// Steps of one standard error each, independent of each other, that make up a covariance.
std::vector<Eigen::VectorXd> independent_steps(const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::VectorXd> steps;
  if (covariance.size() == 0 || !covariance.allFinite()) return steps;
  // Of unit diagonal first: the parameters' units are worlds apart.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  for (Eigen::Index k = 0; k < scale.size(); ++k) {
    const double variance = eigen.eigenvalues()(k);
    if (variance > 1e-12)
      steps.push_back(std::sqrt(variance) * scale.cwiseProduct(eigen.eigenvectors().col(k)));
  }
  return steps;
}

/// The body's material moved by `part` of each step there is.
std::vector<fem::Material> neighbours(const fem::Material& material, fem::Damping damping,
                                      const IdentifiedParameters& identified) {
  std::vector<fem::Material> all;
  const auto vary = [&](const IdentifiedCurve& curve, fem::FrequencyLaw fem::Material::*law) {
    if (curve.laws.empty()) return;
    for (const Eigen::VectorXd& step : independent_steps(curve.laws.front().covariance)) {
      all.push_back(material);
      all.back().*law = moved(material.*law, part * step);
    }
  };
  vary(identified.modulus, &fem::Material::youngs_modulus);
  if (damping == fem::Damping::structural) {
    vary(identified.loss_factor, &fem::Material::loss_factor);
  } else if (identified.rayleigh_known && identified.rayleigh.determined) {
    const RayleighFit& fit = identified.rayleigh;
    Eigen::Matrix2d covariance;
    covariance << std::pow(fit.alpha_sigma, 2.0), fit.covariance, fit.covariance,
        std::pow(fit.beta_sigma, 2.0);
    for (const Eigen::VectorXd& step : independent_steps(covariance)) {
      all.push_back(material);
      all.back().rayleigh.alpha += part * step[0];
      all.back().rayleigh.beta += part * step[1];
    }
  }
  return all;
}

}  // namespace

Eigen::MatrixXd PredictionBand::sigma() const {
  return (0.5 * (real_sigma.cwiseAbs2() + imag_sigma.cwiseAbs2())).cwiseSqrt();
}

PredictionBand prediction_band(const fem::Model& model, const fem::Drive& drive,
                               const fem::Measurement& measurement, const Eigen::VectorXd& frequency_hz,
                               fem::Damping damping, const IdentifiedParameters& identified) {
  fem::Model varied = model;
  const auto response = [&](const fem::Material& material) {
    varied.body.material = material;
    return fem::harmonic_response(varied, drive, measurement, frequency_hz, {damping, false}).response;
  };
  const Eigen::MatrixXcd h = response(model.body.material);
  const Eigen::ArrayXXcd direction = h.array() / h.array().abs().max(1e-300).cast<std::complex<double>>();
  Eigen::ArrayXXd real = Eigen::ArrayXXd::Zero(h.rows(), h.cols()), imag = real, magnitude = real;
  for (const fem::Material& material : neighbours(model.body.material, damping, identified)) {
    const Eigen::ArrayXXcd change = (response(material) - h).array() / part;
    real += change.real().square();
    imag += change.imag().square();
    magnitude += (change * direction.conjugate()).real().square();
  }
  return {real.sqrt(), imag.sqrt(), magnitude.sqrt()};
}

}  // namespace struna::ident
