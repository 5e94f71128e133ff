#pragma once

#include <complex>

#include "fem/material.hpp"

namespace struna::ident {

/// A pole: what all outputs share.
///   structural  g(omega) = 1/(omega_r^2 (1 + i eta) - omega^2)
///   viscous     g(omega) = 1/(i omega - p),  p = omega_r (-zeta + i sqrt(1 - zeta^2)),  zeta = eta/2
struct Pole {
  double natural_frequency_hz = 0.0;  ///< omega_r/(2 pi)
  double loss_factor = 0.0;           ///< eta; viscous: 2 zeta
};

/// p [rad/s] of a viscous pole; below critical damping (loss factor < 2).
std::complex<double> viscous_root(const Pole& pole);

/// g(omega) [s^2], viscous [s].
std::complex<double> pole_function(const Pole& pole, double omega, fem::Damping damping);

/// 1/max|g|: what makes g dimensionless with peak 1: omega_r^2 eta, viscous omega_r zeta.
double pole_scale(const Pole& pole, fem::Damping damping);

/// A mode's share of a function in circle form: C g; viscous: C g(omega) + conj(C g(-omega)).
std::complex<double> modal_share(const std::complex<double>& constant, const Pole& pole, double omega,
                                 fem::Damping damping);

/// Angle law of the circle: 2 atan(x) is the angle from the resonance point, seen from the centre, with
/// x = (1 - (f/f_r)^2)/eta; viscous x = (omega_d - omega)/(zeta omega_r), omega_d the damped natural
/// frequency. Then g is proportional to 1/(x + i).
double angle_coordinate(const Pole& pole, double f_hz, fem::Damping damping);

/// Frequencies a quarter turn either side of resonance [Hz]: f_r sqrt(1 -+ eta); viscous, of the mobility:
/// f_r (sqrt(1 + zeta^2) -+ zeta). The lower one is 0 where eta > 1.
double lower_half_power_hz(const Pole& pole, fem::Damping damping);
double upper_half_power_hz(const Pole& pole, fem::Damping damping);

/// Half-power bandwidth to first order, eta f_r [Hz].
double bandwidth_hz(const Pole& pole);

/// Loss factor from half-power frequencies: (f2^2 - f1^2)/(2 f_r^2), physics eq. (13); viscous (f2 - f1)/f_r,
/// which is exact for a mobility.
double half_power_loss_factor(double lower_hz, double upper_hz, double resonance_hz, fem::Damping damping);

}  // namespace struna::ident
