#pragma once

#include <string>
#include <vector>

#include "fem/harmonic.hpp"
#include "ident/body_errors.hpp"
#include "ident/law_fit.hpp"
#include "ident/mode.hpp"
#include "ident/pairing.hpp"
#include "ident/rayleigh_fit.hpp"

namespace struna::ident {

struct FitOptions {
  /// "constant", "power", "fractional_zener", "monotone_spline"; "" lets AICc choose.
  std::string modulus_law = {};
  std::string loss_factor_law = {};
  double band_lo_hz = 0.0;
  double band_hi_hz = 0.0;
  PairingOptions pairing = {};
  /// Numbers of the body to fit beside the modulus law (fem::fittable_numbers()); the law is then constant or
  /// power (the default).
  std::vector<std::string> free = {};
  /// Relative modelling errors (geometry, ends; leakage, dispersion) added in square to every sigma of E and
  /// of eta.
  double modulus_floor = 1e-3;
  double loss_factor_floor = 1e-2;
};

/// The kind of a law that can be fitted; throws Error on another word, "table" among them.
fem::FrequencyLaw::Kind fitted_law(const std::string& word);

/// A quantity at the trusted modes, and its laws, best first.
struct IdentifiedCurve {
  Eigen::VectorXd frequency_hz;
  Eigen::VectorXd value;
  Eigen::VectorXd sigma;
  std::vector<LawFit> laws;  ///< laws.front() is the one that predictions use
  /// What errors of the body's stated and of its fitted numbers add to `sigma`, which is of noise and of the
  /// model's floor; each common to all modes. Of the modulus; empty: none.
  Eigen::VectorXd scene_sigma = {};
  Eigen::VectorXd fitted_sigma = {};
};

/// What a measured mode was not trusted for.
enum class LeftOutOf { both, modulus, loss_factor };
std::string to_string(LeftOutOf what);           ///< "both", "modulus", "loss_factor"
LeftOutOf left_out_of(const std::string& word);  ///< throws Error on another word

struct LeftOut {
  double frequency_hz = 0.0;
  std::string reason;
  LeftOutOf what = LeftOutOf::both;
};

/// Where a result comes from.
struct Provenance {
  std::string program_version;
  std::string date;                                         ///< ISO 8601, UTC
  std::vector<std::pair<std::string, std::string>> inputs;  ///< file name, SHA-256
  double band_lo_hz = 0.0;
  double band_hi_hz = 0.0;
};

struct IdentifiedParameters {
  std::string body;
  RayleighFit rayleigh;
  bool rayleigh_known = false;  ///< false without any trusted damping
  IdentifiedCurve modulus;      ///< [Pa]
  IdentifiedCurve loss_factor;  ///< [-], freed of the rising modulus' bias
  Eigen::VectorXd
      kramers_kronig_loss_factor;     ///< (pi/2) d ln E/d ln f at the same frequencies, for information
  FittedNumbers fitted;               ///< of the body, beside the modulus
  std::vector<BodyErrorStep> errors;  ///< of the body's numbers, and what they do to the modulus
  std::vector<LeftOut> rejected;
  Pairing pairing;  ///< its model modes count all of the body's from 0, rigid ones included
  Provenance provenance;
};

/// Modes -> Rayleigh coefficients, E(f), eta(f) of the model's body (docs/parameter_identification.md).
///
/// A mode may be trusted for the modulus and not for the loss factor. The loss factor of each mode is read as
/// eta/(1 - n/2) by every fit when E ~ f^n: it is multiplied by (1 - n/2) with n from the fitted modulus law
/// (physics.md, section 3). The same holds for the damping ratios behind alpha and beta, as the viscous
/// model's stiffness is E(f) too. Where options.free names numbers of the body, they are fitted beside the
/// law (ident/joint_fit.hpp), `model` being the body as the scene has it. Standard errors that the modes do
/// not have are taken as 0.5 % of E and 5 % of eta. Throws Error when no mode can be paired, a named law is
/// unknown or not determined by the points, or an option is out of range.
IdentifiedParameters identify_parameters(const ModeSet& measured, const fem::Model& model,
                                         const fem::Drive& drive, const fem::Measurement& measurement,
                                         const FitOptions& options = {});

/// The body's material with what was identified in place of what was known.
fem::Material apply(const IdentifiedParameters& identified, fem::Material material);
/// The body with that material and the numbers that were fitted.
fem::Body apply(const IdentifiedParameters& identified, fem::Body body);

}  // namespace struna::ident
