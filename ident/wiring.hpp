#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "fem/harmonic.hpp"
#include "ident/elastic_modes.hpp"
#include "ident/mode.hpp"
#include "ident/pairing.hpp"

namespace struna::ident {

/// How far measured modal constants bear out the model modes that they are paired with. Only sound modes with
/// constants count (no noisy, poor_circle, edge, not_converged).
struct ShapeAgreement {
  int modes = 0;     ///< sound measured modes
  int pairs = 0;     ///< of them paired
  int agreeing = 0;  ///< of these, with the model's shape and sign over the outputs (correlation above 0.8,
                     ///< or what noise leaves of it) and, up to one common factor, its strength (within 2)
  double median_mac = std::numeric_limits<double>::quiet_NaN();
  /// The common factor: median over the pairs of |C| over the model's; NaN where the form is unknown.
  double level = std::numeric_limits<double>::quiet_NaN();
  double level_scatter_db =
      0.0;  ///< 1.48 median |deviation| from it: the standard deviation of normal scatter
};

/// `pairing` counts the elastic modes from 0, as pair_modes does.
ShapeAgreement shape_agreement(const ModeSet& measured, const ModelModes& model, const Pairing& pairing);

/// One change of cables or scene under which the measured modes would agree with the model's.
struct Remedy {
  enum class Change { output_reversed, outputs_exchanged, driven_along };
  Change change = Change::output_reversed;
  std::vector<int> outputs;  ///< output_reversed: the one; outputs_exchanged: per output of the model's the
                             ///< measured one that is it
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< driven_along
  ShapeAgreement agreement;                             ///< with the change
};

/// Tries each output reversed, each exchange of outputs (all orders of up to three, pairs of more), and the
/// drive along each axis, pairing anew. nullopt unless one change makes four fifths of the modes agree, and
/// clearly more than now.
std::optional<Remedy> find_remedy(const ModeSet& measured, const fem::Model& model, const fem::Drive& drive,
                                  const fem::Measurement& measurement, const PairingOptions& options,
                                  const ShapeAgreement& now);

}  // namespace struna::ident
