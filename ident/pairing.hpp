#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/harmonic.hpp"
#include "ident/mode.hpp"

namespace struna::ident {

/// The model's side: eigenvalues at unit modulus and modal constants per output (circle form).
struct ModelModes {
  Eigen::VectorXd eigenvalue;   ///< ascending
  Eigen::MatrixXd constant;     ///< modes x outputs, at E = 1 Pa (force/motion scales with E(f))
  bool constant_scales_with_modulus = true;
};

/// A measured mode and the model mode(s) it stands for.
struct Pair {
  int measured = -1;
  std::vector<int> model;       ///< one, or the members of a nearly double group that one pole stands for
  double mac = 0.0;             ///< modal assurance of the constants over the outputs, 0..1
  double modulus = 0.0;         ///< E that puts the model mode(s) at the measured frequency [Pa]
  double modulus_sigma = 0.0;
};
struct Unpaired {
  int measured = -1;
  std::string reason;
};
struct Pairing {
  std::vector<Pair> pairs;       ///< ascending
  std::vector<Unpaired> left_out;
  std::vector<int> missing;      ///< model modes in the band that were not measured
  double modulus_at_1_hz = 0.0;  ///< of the coarse law E = E1 f^n that paired them
  double modulus_slope = 0.0;    ///< n
};

struct PairingOptions {
  double modulus_lo = 1e6;   ///< [Pa] range of the global search
  double modulus_hi = 1e12;
  double slope_lo = -0.1;
  double slope_hi = 0.3;
};

/// Pairs measured with model modes although some are missing, doubled or spurious: global search over the modulus level and slope
/// (NLopt DIRECT-L, then a local one) of an assignment cost made of frequency misfit and modal constants.
Pairing pair_modes(const ModeSet& measured, const ModelModes& model, const PairingOptions& options = {});

}  // namespace struna::ident
