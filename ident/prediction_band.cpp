#include "ident/prediction_band.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace struna::ident {
namespace {

using Complex = std::complex<double>;

constexpr double part = 0.01;  // of a standard error
constexpr double nudge =
    1e-6;  // relative: resonances shift by far less than their width, rounding stays below

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

/// Derivatives of the response, lines x outputs. All that a law does goes through the complex modulus
/// s = E (1 + i eta), viscous E (1 + i omega beta), and through alpha.
struct Sensitivity {
  Eigen::ArrayXXcd modulus;  ///< dH / d ln s
  Eigen::ArrayXXcd alpha;    ///< dH / d alpha; empty for structural damping
};

/// What one step of one standard error makes of ln s at each line, and of alpha.
struct Effect {
  Eigen::ArrayXcd log_modulus;
  double alpha = 0.0;
};

std::vector<Effect> effects(const fem::Material& material, const Eigen::VectorXd& frequency_hz,
                            fem::Damping damping, const IdentifiedParameters& identified) {
  const bool structural = damping == fem::Damping::structural;
  std::vector<Effect> all;
  const auto at_lines = [&](const auto& value) {
    Eigen::ArrayXcd result(frequency_hz.size());
    for (Eigen::Index i = 0; i < result.size(); ++i) result(i) = value(frequency_hz(i));
    return result;
  };
  const auto law_steps = [&](const IdentifiedCurve& curve) {
    return curve.laws.empty() ? std::vector<Eigen::VectorXd>{}
                              : independent_steps(curve.laws.front().covariance);
  };
  const auto change = [](const fem::FrequencyLaw& law, const fem::FrequencyLaw& other, double f) {
    return (other.at(f) - law.at(f)) / part;
  };
  for (const Eigen::VectorXd& step : law_steps(identified.modulus)) {
    const fem::FrequencyLaw& law = material.youngs_modulus;
    const fem::FrequencyLaw other = moved(law, part * step);
    all.push_back({at_lines([&](double f) { return Complex(change(law, other, f) / law.at(f)); })});
  }
  if (structural) {
    for (const Eigen::VectorXd& step : law_steps(identified.loss_factor)) {
      const fem::FrequencyLaw& law = material.loss_factor;
      const fem::FrequencyLaw other = moved(law, part * step);
      all.push_back({at_lines(
          [&](double f) { return Complex(0.0, change(law, other, f)) / Complex(1.0, law.at(f)); })});
    }
  } else if (identified.rayleigh_known && identified.rayleigh.determined) {
    const RayleighFit& fit = identified.rayleigh;
    Eigen::Matrix2d covariance;
    covariance << std::pow(fit.alpha_sigma, 2.0), fit.covariance, fit.covariance,
        std::pow(fit.beta_sigma, 2.0);
    for (const Eigen::VectorXd& step : independent_steps(covariance)) {
      all.push_back({at_lines([&](double f) {
                       const double omega = 2.0 * std::numbers::pi * f;
                       return Complex(0.0, omega * step[1]) / Complex(1.0, omega * material.rayleigh.beta);
                     }),
                     step[0]});
    }
  }
  return all;
}

}  // namespace

Eigen::MatrixXd PredictionBand::sigma() const {
  return (0.5 * (real_sigma.cwiseAbs2() + imag_sigma.cwiseAbs2())).cwiseSqrt();
}

PredictionBand prediction_band(const fem::Model& model, const fem::Drive& drive,
                               const fem::Measurement& measurement, const fem::HarmonicResponse& response,
                               fem::Damping damping, const IdentifiedParameters& identified) {
  const Eigen::VectorXd& frequency_hz = response.frequency_hz;
  const auto response_of = [&](const fem::Model& other) {
    return Eigen::ArrayXXcd(
        fem::harmonic_response(other, drive, measurement, frequency_hz, {damping, false}).response.array());
  };
  const Eigen::ArrayXXcd h = response.response.array();
  fem::Model varied = model;
  varied.stiffness.lower *= 1.0 + nudge;
  Sensitivity sensitivity{(response_of(varied) - h) / nudge, {}};
  if (damping == fem::Damping::viscous) {
    varied = model;
    const double step = nudge * 2.0 * std::numbers::pi * frequency_hz.maxCoeff();
    varied.body.material.rayleigh.alpha += step;
    sensitivity.alpha = (response_of(varied) - h) / step;
  }

  const Eigen::ArrayXXcd direction = h / h.abs().max(1e-300).cast<Complex>();
  Eigen::ArrayXXd real = Eigen::ArrayXXd::Zero(h.rows(), h.cols()), imag = real, magnitude = real;
  for (const Effect& effect : effects(model.body.material, frequency_hz, damping, identified)) {
    Eigen::ArrayXXcd change = sensitivity.modulus.colwise() * effect.log_modulus;
    if (effect.alpha != 0.0) change += effect.alpha * sensitivity.alpha;
    real += change.real().square();
    imag += change.imag().square();
    magnitude += (change * direction.conjugate()).real().square();
  }
  return {real.sqrt(), imag.sqrt(), magnitude.sqrt()};
}

}  // namespace struna::ident
