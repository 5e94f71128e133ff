#pragma once

#include <Eigen/Core>

#include "fem/harmonic.hpp"
#include "ident/parameter_identification.hpp"

namespace struna::ident {

/// Standard errors of a predicted function, lines x outputs, in its unit.
struct PredictionBand {
  Eigen::MatrixXd real_sigma;
  Eigen::MatrixXd imag_sigma;
  Eigen::MatrixXd magnitude_sigma;  ///< of |H|
  Eigen::MatrixXd sigma() const;    ///< root mean square of real_sigma and imag_sigma
};

/// What the covariance of the laws E(f) and eta(f) (viscous: of alpha and beta in place of eta) makes of the
/// harmonic response, to first order: sum over the eigenvectors of each covariance of (dH/dp d)^2. H depends
/// on the laws through the complex modulus at its own frequency only, so one derivative serves all. The laws
/// of different quantities count as independent: errors of natural frequencies and of loss factors are nearly
/// so.
///
/// Beyond the data of a law its spread (spread_beyond_data) adds to its errors.
///
/// Besides, what the errors of the body's numbers make of it: those that identification knew
/// (identified.errors) move the modulus and the body together, wherever the body states the same number with
/// the same value, and the modulus alone elsewhere; numbers that only this body states with a sigma move the
/// body alone.
///
/// `model` carries the laws (apply). Zero where no covariance is known. `response` is the harmonic
/// response of the same model, with the same damping. Costs one more of its kind, two when damping is
/// viscous, and one for each error of the body.
PredictionBand prediction_band(const fem::Model& model, const fem::Drive& drive,
                               const fem::Measurement& measurement, const fem::HarmonicResponse& response,
                               fem::Damping damping, const IdentifiedParameters& identified);

}  // namespace struna::ident
