#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "fem/eigenmodes.hpp"
#include "fem/model.hpp"

namespace struna::fem {

/// A causal complex modulus with a fading memory (generalised Maxwell),
///   E*(s) = relaxed + sum_j strength_j s tau_j/(1 + s tau_j) + viscosity s [Pa],   s = i w,
/// all parameters >= 0, so that it never gives energy. docs/pole_system.md.
struct MaxwellLaw {
  double relaxed = 0.0;             ///< modulus at rest [Pa]
  Eigen::VectorXd relaxation_time;  ///< tau_j [s]
  Eigen::VectorXd strength;         ///< [Pa]
  double viscosity = 0.0;           ///< [Pa s]

  std::complex<double> at(std::complex<double> s) const;
  std::complex<double> derivative(std::complex<double> s) const;
};

/// The Maxwell law nearest to E(f)(1 + i eta(f)) over [lo, hi], relative and complex, by non-negative least
/// squares (Lawson & Hanson, Solving Least Squares Problems, ch. 23). A pair of laws that is not causal
/// itself (eta other than pi/2 d ln E/d ln f) is met only in the mean.
MaxwellLaw fit_maxwell_law(const FrequencyLaw& youngs_modulus, const FrequencyLaw& loss_factor, double lo_hz,
                           double hi_hz);

/// The same law, its memory and its relaxed modulus scaled so that E(f) and eta(f) are met exactly at `f_hz`.
/// Above the band of the fit, which ends at `fitted_to_hz`, where the memory loses nothing any more, it is
/// scaled as at that end, and so that no less than a tenth of the modulus stays elastic; a dashpot gives what
/// is missing of the loss. Throws Error unless modulus and frequency are positive and the loss factor is not
/// negative.
MaxwellLaw exact_at(const MaxwellLaw& law, double youngs_modulus, double loss_factor, double f_hz,
                    double fitted_to_hz);

/// A linear body in time as a sum of first-order poles, the form in which it is stepped exactly. Mode m under
/// the modal load p_m:
///   z_k' = pole_k z_k + residue_k p_m,   q_m = Re sum_k z_k over the poles of mode m.
/// One pole of each conjugate pair (its residue doubled), real poles as they are. The sums of the real parts
/// of the residues vanish and those of residue times pole are 1, so
///   q_m' = Re sum pole_k z_k,   q_m'' = Re sum pole_k^2 z_k + p_m.
/// Viscous modes have one complex pole (or two real ones); causal viscoelastic modes some real poles besides.
/// A rigid mode, q'' + alpha q' = p, has the one real pole of its velocity, -alpha, 0 without drag, and the
/// residue 1: its state is q and q' themselves, see is_rigid_pole().
struct PoleSystem {
  Eigen::VectorXcd pole;     ///< [1/s], Re <= 0; those of a mode follow each other
  Eigen::VectorXi mode;      ///< the mode each pole belongs to
  Eigen::VectorXcd residue;  ///< [s]
  int modes = 0;
  MaxwellLaw
      law;  ///< the body's modulus in time: acts in its static stiffness (reactions), common to all modes
  Eigen::VectorXd natural_frequency_hz;  ///< of the modes
  Eigen::VectorXd
      relaxed_stiffness;  ///< q_m = p_m/relaxed_stiffness under a constant load [1/s^2]; 0 for a rigid mode
  /// Under the loads of a static rest [1/s^2]: lambda E at rest_frequency_hz(); empty: the relaxed stiffness.
  Eigen::VectorXd rest_stiffness;
};

/// Whether the poles begin..end of one mode are a rigid one's: a single real pole. Nothing else that has mass
/// has just one.
bool is_rigid_pole(const PoleSystem& system, int begin, int end);

/// Poles of the modes of a body. viscous: q'' + (alpha + beta w^2) q' + w^2 q = p, w^2 = E(f_r) lambda_r.
/// structural: q'' + lambda_r E*_r(d/dt) q = p with the Maxwell law fitted from a third of the lowest natural
/// frequency or of `band_hi_hz` to the higher of the two, made exact at each resonance.
PoleSystem pole_system(const Model& model, const Eigenmodes& modes, Damping damping, double band_hi_hz);

/// The lowest frequency at which a modulus is known, which stands for rest [Hz]: where its data or its table
/// begin, else `lowest_natural_hz`. The fitted memory's modulus at 0 Hz is no material's: below the band a
/// loss factor that stays finite would relax without end.
double rest_frequency_hz(const FrequencyLaw& youngs_modulus, double lowest_natural_hz);

/// q_m/p_m at s = i w, w = 2 pi f [s^2].
std::complex<double> modal_receptance(const PoleSystem& system, int mode, double f_hz);

}  // namespace struna::fem
