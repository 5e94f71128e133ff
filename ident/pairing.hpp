#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/harmonic.hpp"
#include "ident/mode.hpp"

namespace struna::ident {

/// The model's side: eigenvalues at unit modulus and modal constants per output (circle form).
struct ModelModes {
  Eigen::VectorXd eigenvalue;                ///< ascending
  Eigen::MatrixXd constant;                  ///< modes x outputs, at E = 1 Pa
  bool constant_scales_with_modulus = true;  ///< force/motion: C ~ E(f); displacement/force: not
};

/// A measured mode and the model mode(s) it stands for.
struct Pair {
  int measured = -1;       ///< index in ModeSet::modes
  std::vector<int> model;  ///< one, or the members of a nearly double group that one pole stands for
  double mac = 0.0;        ///< modal assurance of the constants over the outputs, 0..1; NaN without constants
  double modulus = 0.0;    ///< E that puts the model mode(s) at the measured frequency [Pa]
  /// Of the measured frequency, and of what stays open inside a nearly double group.
  double modulus_sigma = 0.0;
  /// Of a group, relative: the frequency step of two equal modes as wide; 0 for one mode.
  double spread = 0.0;
};
struct Unpaired {
  int measured = -1;
  std::string reason;
};
/// Another explanation of the same modes: mostly other pairs at another modulus, or chance.
struct RivalPairing {
  int pairs = 0;         ///< 0: none of the model's modes is there, the modes fit by chance
  double modulus = 0.0;  ///< its own, at the mean measured frequency [Pa]; 0 for chance
  double odds = 0.0;     ///< its probability over that of the pairing
};
struct Pairing {
  std::vector<Pair> pairs;  ///< ascending
  std::vector<Unpaired> left_out;
  std::vector<int> missing;      ///< model modes in the band that were not measured
  double modulus_at_1_hz = 0.0;  ///< of the coarse law E = E1 f^n that paired them
  double modulus_slope = 0.0;    ///< n
  bool sign_reversed =
      false;           ///< all measured constants have the sign opposite to the model's: a channel's sign
  RivalPairing rival;  ///< the most probable one
};

struct PairingOptions {
  double modulus_lo = 1e6;  ///< [Pa] range of the global search
  double modulus_hi = 1e12;
  double slope_lo = -0.1;
  double slope_hi = 0.3;
  double band_lo_hz =
      0.0;  ///< where modes were looked for; 0, 0: from the lowest to the highest measured one
  double band_hi_hz = 0.0;
};

/// Throws Error naming field, rule and value.
void validate(const PairingOptions& options);

/// Pairs measured with model modes although some are missing, doubled or spurious: global search over the
/// modulus level and slope (NLopt DIRECT-L, then Sbplx) of the cost of the cheapest assignment, made of
/// frequency misfit and modal constants; of the laws that it finds, the most probable one (docs/pairing.md).
/// A pair that another explanation rivals, or whose modulus or constants stand out, is left out with its
/// reason. Constants are used where the modes have them. Throws Error when their number differs from the
/// model's outputs.
Pairing pair_modes(const ModeSet& measured, const ModelModes& model, const PairingOptions& options = {});

}  // namespace struna::ident
