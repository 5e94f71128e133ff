#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fem/material.hpp"

namespace struna::ident {

struct LawFit {
  fem::FrequencyLaw law;
  Eigen::VectorXd
      parameter_sigma;  ///< of law.parameters (0 for the power law's reference frequency), or of law.value
  Eigen::MatrixXd covariance;  ///< of the same; empty where not known
  double aicc = 0.0;  ///< Akaike's information criterion, corrected for few points, at a scatter common to
                      ///< all laws offered (docs/law_fit.md); infinite without a degree of freedom
  double rms = 0.0;   ///< weighted rms residual per degree of freedom, over sigma
};

/// Standard error of the law's value at f, to first order in its parameters; 0 without covariance.
double law_sigma(const LawFit& fit, double f_hz);

/// Largest standard error [of the value] of a law beyond its data that need not be pointed out: half of it is
/// that of a natural frequency.
inline constexpr double extrapolation_tolerance = 0.01;

/// How far, relative to its value, what laws.front() says at f beyond its data is uncertain for want of data;
/// 0 within it, or where the laws' covariances are not known. With L = ln(f/edge of the data), n_k a law's
/// logarithmic slope at the edge, d_k its own ln(value(f)/value(edge)), weights w_k = exp(-AICc/2):
///   sum of w_k [(d_k - d_front)^2 + (n_k L)^2] + (2 sigma_n L)^2.
/// Laws that fit alike part (Burnham & Anderson 2002, sec. 4.3); each may go on as it leaves the data or
/// flatten at once; and a slope at an end is known half as well at best as the mean slope, of which sigma_n
/// is the standard error (from the power law). See docs/law_fit.md.
double spread_beyond_data(const std::vector<LawFit>& laws, double f_hz);

/// Standard error of the value that laws.front() has at f: law_sigma, and beyond the data its spread too.
double law_sigma(const std::vector<LawFit>& laws, double f_hz);

/// Whether f lies beyond the data and that standard error above extrapolation_tolerance, or is not known.
bool is_extrapolated(const std::vector<LawFit>& laws, double f_hz);

/// The law with its numbers (law.parameters, or law.value) moved by `step`.
fem::FrequencyLaw moved(fem::FrequencyLaw law, const Eigen::VectorXd& step);

/// Fits E(f) or eta(f) at points with standard deviations: every law in `kinds` that the points determine
/// (Ceres, in the logarithm of the value), best AICc first; but of laws within 2 of the best, the one with
/// the fewest parameters comes first. The standard deviations are taken as a lower limit: the scatter that
/// the best of the laws leaves, when larger, counts as the scale of the errors of all.
///
/// power needs 2 points, the spline 5, the fractional Zener 6 and a relaxation that the points show
/// (parameters off their bounds and known to a factor of e); a law that is not offered is absent. The
/// monotone spline takes 3 to 6 knots, as AICc likes, and, for `rising`, does not fall; neither does a rising
/// fractional Zener. Throws Error on lengths that differ, values that are not positive, or kind table.
std::vector<LawFit> fit_laws(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& value,
                             const Eigen::VectorXd& sigma, const std::vector<fem::FrequencyLaw::Kind>& kinds,
                             bool rising);

}  // namespace struna::ident
