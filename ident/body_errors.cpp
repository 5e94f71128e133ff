#include "ident/body_errors.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace struna::ident {
namespace {

constexpr double part = 1e-3;  // of a step, over which a law is straight

/// d ln(law)/d(its numbers) at f, times `scale` of each number; 0 for numbers of scale 0.
Eigen::RowVectorXd log_gradient(const fem::FrequencyLaw& law, const Eigen::VectorXd& scale, double f_hz) {
  Eigen::RowVectorXd gradient = Eigen::RowVectorXd::Zero(scale.size());
  for (Eigen::Index k = 0; k < scale.size(); ++k) {
    if (!(scale[k] > 0.0)) continue;
    const Eigen::VectorXd step = part * scale[k] * Eigen::VectorXd::Unit(scale.size(), k);
    gradient[k] = std::log(moved(law, step).at(f_hz) / moved(law, -step).at(f_hz)) / (2.0 * part);
  }
  return gradient;
}

/// The least squares that law and fitted numbers answer an error with.
///
/// ln E_i = const - ln lambda_i. With the law's numbers y (in their scales) and the fitted ones z,
///   d ln E = -a - B z + g e,  J y ~ d ln E weighted,  e = j y,
/// a the error's own slopes, B those of the fitted numbers, g those of the stiffness over E0 of supports that
/// are stated in N/m and N m/rad, whose E0 is the law's (j: its gradient at that frequency).
class Response {
 public:
  Response(const fem::Model& model, const fem::Eigenmodes& modes, const std::vector<PairedFrequency>& pairs,
           const LawFit& law, const FittedNumbers& fitted)
      : scale_(law.parameter_sigma.cwiseAbs()), weight_(static_cast<Eigen::Index>(pairs.size())) {
    const Eigen::Index n = weight_.size();
    law_.resize(n, scale_.size());
    for (Eigen::Index i = 0; i < n; ++i) {
      const PairedFrequency& pair = pairs[static_cast<std::size_t>(i)];
      weight_[i] = 1.0 / pair.sigma;
      law_.row(i) = log_gradient(law.law, scale_, pair.frequency_hz);
    }
    reference_ = log_gradient(law.law, scale_, fem::support_reference_hz);
    fitted_.resize(n, static_cast<Eigen::Index>(fitted.name.size()));
    for (Eigen::Index k = 0; k < fitted_.cols(); ++k) {
      const std::string& name = fitted.name[static_cast<std::size_t>(k)];
      const fem::BodyNumber number = fem::fittable_number(model.body, name);
      fitted_.col(k) = over_pairs(pairs, fem::log_eigenvalue_slopes(model, modes, number));
      if (is_relative(name)) fitted_.col(k) *= number.value;
    }
    support_ = support_slopes(model, modes, pairs, fitted);
  }

  /// Of an error that moves ln lambda by `slopes`: the law's numbers, the fitted ones, d ln E at the modes
  /// and at the supports' reference.
  struct Change {
    Eigen::VectorXd law;
    Eigen::VectorXd fitted;
    Eigen::VectorXd log_modulus;
    double reference = 0.0;
  };
  Change of_error(const Eigen::VectorXd& slopes) const {
    Eigen::MatrixXd columns(law_.rows(), law_.cols() + fitted_.cols());
    columns << law_, fitted_;
    const Eigen::VectorXd answer = solved(columns, -slopes);
    return change(slopes, answer.head(law_.cols()), answer.tail(fitted_.cols()));
  }
  /// Of a change of the fitted numbers themselves.
  Change of_fitted(const Eigen::VectorXd& step) const {
    const Eigen::VectorXd slopes = fitted_ * step;
    return change(Eigen::VectorXd::Zero(slopes.size()), solved(law_, -slopes), step);
  }
  /// Weighted mean over the modes.
  double level(const Eigen::VectorXd& at_modes) const {
    return weight_.cwiseAbs2().dot(at_modes) / weight_.squaredNorm();
  }

 private:
  /// Stiffness over E0 of the springs that are not fitted: d ln lambda/d ln of it, all together.
  static Eigen::VectorXd support_slopes(const fem::Model& model, const fem::Eigenmodes& modes,
                                        const std::vector<PairedFrequency>& pairs,
                                        const FittedNumbers& fitted) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(pairs.size()));
    for (const std::string end : {"start", "end"}) {
      for (const std::string field : {"rotation", "translation"}) {
        const auto is_fitted = [&](const std::string& name) {
          return std::find(fitted.name.begin(), fitted.name.end(), name + "." + field) != fitted.name.end();
        };
        const fem::ElasticSupport& support =
            end == "start" ? model.body.start_support : model.body.end_support;
        const bool gives = field == "rotation" ? support.gives_rotation() : support.gives_translation();
        if (!gives || is_fitted(end) || is_fitted("both")) continue;
        const fem::BodyNumber number = fem::fittable_number(model.body, end + "." + field);
        sum += number.value * over_pairs(pairs, fem::log_eigenvalue_slopes(model, modes, number));
      }
    }
    return sum;
  }

  /// y with columns y ~ right + g (j y) in the weighted least squares sense.
  Eigen::VectorXd solved(const Eigen::MatrixXd& columns, const Eigen::VectorXd& right) const {
    if (columns.cols() == 0) return {};
    Eigen::MatrixXd weighted = weight_.asDiagonal() * columns;
    // Columns of unit length, so that a rank found means something; those of fixed numbers are zero and stay
    // so.
    const Eigen::VectorXd length = weighted.colwise().norm();
    const Eigen::VectorXd inverse = length.unaryExpr([](double l) { return l > 0.0 ? 1.0 / l : 0.0; });
    weighted = weighted * inverse.asDiagonal();
    const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr(weighted);
    const auto answer = [&](const Eigen::VectorXd& v) {
      return Eigen::VectorXd(inverse.cwiseProduct(qr.solve(weight_.cwiseProduct(v))));
    };
    const Eigen::VectorXd own = answer(right);
    if (support_.isZero(0.0)) return own;
    const Eigen::VectorXd back = answer(support_);
    // y = own + back (j y): j y = j own/(1 - j back).
    const auto at_reference = [&](const Eigen::VectorXd& y) {
      return reference_.dot(y.head(reference_.size()));
    };
    return own + at_reference(own) / (1.0 - at_reference(back)) * back;
  }

  Change change(const Eigen::VectorXd& slopes, const Eigen::VectorXd& law,
                const Eigen::VectorXd& fitted) const {
    Change c{scale_.cwiseProduct(law), fitted, {}, reference_.dot(law)};
    c.log_modulus = -slopes + c.reference * support_;
    if (fitted.size() > 0) c.log_modulus -= fitted_ * fitted;
    return c;
  }

  Eigen::VectorXd scale_;
  Eigen::VectorXd weight_;
  Eigen::MatrixXd law_;
  Eigen::MatrixXd fitted_;
  Eigen::VectorXd support_;
  Eigen::RowVectorXd reference_;
};

/// The change of a fitted number's value: springs keep their stiffness over E0 but for their own step.
double value_change(const std::string& name, double value, double step, double log_reference) {
  if (!is_relative(name)) return step;
  return value * (name == "torsion_constant" ? step : step + log_reference);
}

BodyErrorStep step_of(const Response& response, const Response::Change& change, const FittedNumbers& fitted) {
  BodyErrorStep step;
  step.modulus = change.log_modulus;
  step.law_step = change.law;
  step.level = response.level(change.log_modulus);
  for (std::size_t k = 0; k < fitted.name.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    step.number.push_back(fitted.name[k]);
    step.change.push_back(
        value_change(fitted.name[k], fitted.value[at], change.fitted[at], change.reference));
  }
  return step;
}

}  // namespace

std::vector<Eigen::VectorXd> independent_steps(const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::VectorXd> steps;
  if (covariance.size() == 0 || !covariance.allFinite()) return steps;
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

Eigen::VectorXd over_pairs(const std::vector<PairedFrequency>& pairs, const Eigen::VectorXd& of_modes) {
  Eigen::VectorXd mean(static_cast<Eigen::Index>(pairs.size()));
  for (Eigen::Index i = 0; i < mean.size(); ++i)
    mean[i] = of_modes(pairs[static_cast<std::size_t>(i)].mode).mean();
  return mean;
}

bool is_relative(const std::string& fitted_number) {
  return !fitted_number.ends_with(".mass");
}

Eigen::VectorXd FittedNumbers::sigma() const {
  Eigen::VectorXd result = covariance.diagonal().cwiseSqrt();
  for (std::size_t k = 0; k < name.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (is_relative(name[k])) result[at] *= value[at];
  }
  return result;
}

std::vector<BodyErrorStep> body_error_steps(const fem::Model& model, const fem::Eigenmodes& modes,
                                            const std::vector<PairedFrequency>& pairs, const LawFit& law,
                                            const FittedNumbers& fitted) {
  std::vector<BodyErrorStep> steps;
  const bool stated = std::any_of(model.body.stated.begin(), model.body.stated.end(),
                                  [](const fem::BodyNumber& number) { return number.sigma > 0.0; });
  if (!stated && fitted.name.empty()) return steps;
  const Response response(model, modes, pairs, law, fitted);
  for (const fem::BodyNumber& number : model.body.stated) {
    if (!(number.sigma > 0.0)) continue;
    // A number that was fitted is no longer what the scene states.
    if (std::find(fitted.name.begin(), fitted.name.end(), number.name) != fitted.name.end()) continue;
    const Eigen::VectorXd slopes =
        number.sigma * over_pairs(pairs, fem::log_eigenvalue_slopes(model, modes, number));
    BodyErrorStep step = step_of(response, response.of_error(slopes), fitted);
    step.of = number.name;
    step.value = number.value;
    step.sigma = number.sigma;
    step.number.insert(step.number.begin(), number.name);
    step.change.insert(step.change.begin(), number.sigma);
    steps.push_back(std::move(step));
  }
  for (const Eigen::VectorXd& direction : independent_steps(fitted.covariance)) {
    BodyErrorStep step = step_of(response, response.of_fitted(direction), fitted);
    step.of = "fitted";
    steps.push_back(std::move(step));
  }
  return steps;
}

Eigen::VectorXd common_modulus_sigma(const std::vector<BodyErrorStep>& steps, bool fitted) {
  Eigen::VectorXd variance;
  for (const BodyErrorStep& step : steps) {
    if (step.is_fitted() != fitted) continue;
    if (variance.size() == 0) variance = Eigen::VectorXd::Zero(step.modulus.size());
    variance += step.modulus.cwiseAbs2();
  }
  return variance.cwiseSqrt();
}

double law_sigma(const fem::FrequencyLaw& law, const std::vector<BodyErrorStep>& steps, bool fitted,
                 double f_hz) {
  double variance = 0.0;
  for (const BodyErrorStep& step : steps) {
    if (step.is_fitted() == fitted)
      variance += std::pow((moved(law, part * step.law_step).at(f_hz) - law.at(f_hz)) / part, 2);
  }
  return std::sqrt(variance);
}

}  // namespace struna::ident
