#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "fem/material.hpp"
#include "ident/stabilisation.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident {

/// What cannot be trusted about a mode. An empty list: a sound mode.
enum class ModeFlag {
  coarse,  ///< too few lines in the half-power band for the estimate to be free of leakage or to be a circle
  close_modes,  ///< a neighbour within a half-power bandwidth: the circle is not this mode's own
  double_mode,  ///< one pole stands for what looks like two (the outputs' lines around it have rank two)
  noisy,  ///< standard error of the frequency above 5 % of the bandwidth, or of the loss factor above 10 %
  edge,   ///< the half-power band reaches past the band analysed
  may_be_two,   ///< noise would hide a second mode too far away to be passed over (resolves_from)
  poor_circle,  ///< scatter about the circle far above the lines' standard deviation
  not_converged
};
std::string to_string(ModeFlag flag);
ModeFlag mode_flag(const std::string& word);

/// The circle of one output of one mode, in circle form (see circle_form).
struct Circle {
  std::complex<double> centre;
  double radius = 0.0;
  std::complex<double> at_resonance;  ///< point at natural_frequency
  std::complex<double> at_lower_half_power;
  std::complex<double> at_upper_half_power;
  double scatter =
      0.0;  ///< rms distance of the points from the geometric circle through them, over its radius
};

/// One identified mode. In circle form, for structural damping,
///   H_k(omega) = C_k / (omega_r^2 (1 + i eta) - omega^2) + slowly varying residual,
/// and for viscous damping H_k = C_k/(i omega - p) + ..., p = omega_r(-zeta + i sqrt(1 - zeta^2)), with
/// omega_r the undamped natural frequency.
struct Mode {
  double natural_frequency_hz = 0.0;
  double natural_frequency_sigma =
      0.0;  ///< standard error; this and the others NaN where the method has none
  double lower_half_power_hz = 0.0;
  double upper_half_power_hz = 0.0;
  double loss_factor = 0.0;  ///< eq. (13): (f2^2 - f1^2)/(2 f0^2); viscous: 2 zeta
  double loss_factor_sigma = 0.0;
  double damping_ratio = 0.0;
  Eigen::VectorXcd
      modal_constant;  ///< C_k per output [unit of the circle form * (rad/s)^2, viscous: * rad/s]
  Eigen::VectorXd modal_constant_sigma;  ///< of the real and of the imaginary part
  std::vector<ModeFlag> flags;
  /// Half-power bandwidths from which on a second mode of equal height would be noticed; NaN: not known.
  double resolves_from = std::numeric_limits<double>::quiet_NaN();

  double circle_natural_frequency_hz = 0.0;  ///< the circle fit's own, NaN when it has none
  double circle_loss_factor = 0.0;
  std::vector<Circle> circles;  ///< per output; empty when not fitted
  double window_lo_hz = 0.0;    ///< lines the circle was fitted to
  double window_hi_hz = 0.0;

  int stable_orders = 0;  ///< model orders in which a pole stands here (stabilisation.hpp) …
  int orders = 0;         ///< … of so many; 0: not analysed

  bool has(ModeFlag flag) const;
};

struct RejectedCandidate {
  double frequency_hz = 0.0;
  std::string reason;
};

struct ModeSet {
  fem::Damping damping = fem::Damping::structural;
  FrfKind form = FrfKind::unknown;  ///< the circle form that the constants and circles refer to
  std::vector<std::string> outputs;
  std::vector<std::string> units;  ///< per output, of the circle form: those of the circles
  std::vector<Mode> modes;         ///< ascending in frequency
  std::vector<RejectedCandidate> rejected;
  Stabilisation stabilisation;  ///< empty for methods that do not ask it
};

/// The form in which a mode is an exact circle. Structural: receptance for motion over force, apparent mass
/// for force over motion, as it is for transmissibility and unknown. Viscous: mobility, apparent mass.
FrfKind circle_form(FrfKind kind, fem::Damping damping);

/// The function in circle form, ready for every mode method.
TransferFunction to_circle_form(const TransferFunction& tf, fem::Damping damping);

}  // namespace struna::ident
