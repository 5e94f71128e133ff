#pragma once

#include <Eigen/Core>

#include "fem/material.hpp"

namespace struna::ident {

/// alpha, beta of eq. (10) from damping ratios at natural frequencies.
struct RayleighFit {
  fem::Rayleigh rayleigh;
  double alpha_sigma = 0.0;  ///< 0 where a bound holds the value
  double beta_sigma = 0.0;
  double covariance = 0.0;      ///< of alpha and beta
  bool alpha_at_bound = false;  ///< held at zero
  bool beta_at_bound = false;
  double rms = 0.0;     ///< weighted rms of the residuals in zeta, over sigma
  double misfit = 0.0;  ///< relative distance of the modes from the curve, rms per degree of freedom, less
                        ///< what their sigmas explain; 0 without a degree of freedom
  double chance = 1.0;  ///< of residuals this large where the curve holds; 1 without a degree of freedom
  bool determined = false;  ///< false when all modes share one frequency (as a single one does): then alpha
                            ///< is 0 with infinite sigma and beta alone carries the damping
};

/// Weighted least squares with alpha, beta >= 0 (Ceres). With equal weights and no active bound it equals the
/// pseudo-inverse (12), rayleigh_pseudo_inverse. Standard errors from the weights' covariance, enlarged by
/// the misfit when that is above 1. Throws Error on sizes that differ, or values not positive.
RayleighFit fit_rayleigh(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& damping_ratio,
                         const Eigen::VectorXd& damping_ratio_sigma);

/// R = A^+ Z, eq. (12): equal weights, no bounds.
fem::Rayleigh rayleigh_pseudo_inverse(const Eigen::VectorXd& frequency_hz,
                                      const Eigen::VectorXd& damping_ratio);

}  // namespace struna::ident
