#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fem/material.hpp"

namespace struna::ident {

struct LawFit {
  fem::FrequencyLaw law;
  Eigen::VectorXd parameter_sigma;  ///< of law.parameters (0 for the power law's reference frequency), or of law.value
  double aicc = 0.0;                ///< Akaike's information criterion, corrected for few points (Hurvich & Tsai 1989)
  double rms = 0.0;                 ///< weighted rms residual per degree of freedom, over sigma
};

/// Fits E(f) or eta(f) at points with standard deviations: every law in `kinds` that the number of points allows
/// (Ceres, in the logarithm of the value), best AICc first. The monotone spline takes as many knots as AICc likes and, for
/// `rising`, does not fall.
std::vector<LawFit> fit_laws(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& value,
                             const Eigen::VectorXd& sigma, const std::vector<fem::FrequencyLaw::Kind>& kinds,
                             bool rising);

}  // namespace struna::ident
