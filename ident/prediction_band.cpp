#include "ident/prediction_band.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "fem/body_number.hpp"
#include "ident/body_errors.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;

constexpr double part = 0.01;         // of a standard error
constexpr double error_share = 1e-3;  // of an error of the body, of which resonances keep almost their place
constexpr double nudge =
    1e-6;  // relative: resonances shift by far less than their width, rounding stays below

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
  const auto& moduli = identified.modulus.laws;
  all.push_back({at_lines([&](double f) { return Complex(spread_beyond_data(moduli, f)); })});
  for (const Eigen::VectorXd& step : law_steps(identified.modulus)) {
    const fem::FrequencyLaw& law = material.youngs_modulus;
    const fem::FrequencyLaw other = moved(law, part * step);
    all.push_back({at_lines([&](double f) { return Complex(change(law, other, f) / law.at(f)); })});
  }
  if (structural) {
    const auto& loss_factors = identified.loss_factor.laws;
    all.push_back({at_lines([&](double f) {
      const double eta = material.loss_factor.at(f);
      return Complex(0.0, eta * spread_beyond_data(loss_factors, f)) / Complex(1.0, eta);
    })});
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

/// The number of that name and value among those that the body states, or null.
const fem::BodyNumber* stated_number(const fem::Body& body, const std::string& name, double value) {
  const auto found = std::find_if(body.stated.begin(), body.stated.end(), [&](const fem::BodyNumber& number) {
    return number.name == name && number.value == value;
  });
  return found == body.stated.end() ? nullptr : &*found;
}

/// The body after a small share of an error: what the modulus was identified with moves together with it, so
/// that natural frequencies, which were measured, hardly do.
fem::Body with_error(fem::Body body, const BodyErrorStep& step, double share) {
  fem::FrequencyLaw& modulus = body.material.youngs_modulus;
  modulus = moved(modulus, share * step.law_step);
  // Of another body (another length, say) the modulus' error is alone.
  const bool same_body = step.is_fitted() || stated_number(body, step.of, step.value) != nullptr;
  if (!same_body) return body;
  for (std::size_t k = 0; k < step.number.size(); ++k) {
    const bool is_stated = !step.is_fitted() && k == 0;
    const fem::BodyNumber number =
        is_stated ? *stated_number(body, step.of, step.value) : fem::fittable_number(body, step.number[k]);
    body = fem::moved(body, number, share * step.change[k]);
  }
  return body;
}

/// The errors of identification, and those of what this body states and that one did not.
std::vector<BodyErrorStep> errors_of(const fem::Body& body, const IdentifiedParameters& identified) {
  std::vector<BodyErrorStep> errors = identified.errors;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(
      body.material.youngs_modulus.parameters.size() + body.material.youngs_modulus.value.size()));
  for (const fem::BodyNumber& number : body.stated) {
    const bool told = std::any_of(errors.begin(), errors.end(), [&](const BodyErrorStep& step) {
      return step.of == number.name && step.value == number.value;
    });
    const auto& fitted = identified.fitted.name;
    if (told || !(number.sigma > 0.0) || std::find(fitted.begin(), fitted.end(), number.name) != fitted.end())
      continue;
    errors.push_back({number.name, number.value, number.sigma, {number.name}, {number.sigma}, 0.0, {}, none});
  }
  return errors;
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
  const auto add = [&](const Eigen::ArrayXXcd& change) {
    real += change.real().square();
    imag += change.imag().square();
    magnitude += (change * direction.conjugate()).real().square();
  };
  for (const Effect& effect : effects(model.body.material, frequency_hz, damping, identified)) {
    Eigen::ArrayXXcd change = sensitivity.modulus.colwise() * effect.log_modulus;
    if (effect.alpha != 0.0) change += effect.alpha * sensitivity.alpha;
    add(change);
  }
  const int elements = static_cast<int>(model.arc_length.size()) - 1;
  for (const BodyErrorStep& step : errors_of(model.body, identified)) {
    const fem::Body moved_body = with_error(model.body, step, error_share);
    add((response_of(fem::assemble(moved_body, elements)) - h) / error_share);
  }
  return {real.sqrt(), imag.sqrt(), magnitude.sqrt()};
}

}  // namespace struna::ident
