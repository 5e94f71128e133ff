#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/mode.hpp"
#include "ident/pairing.hpp"

namespace struna::ident {

/// Distance to the nearest other measured mode, in half-power bandwidths.
double neighbour_distance(const std::vector<Mode>& modes, std::size_t mine);

/// From a pair's first model mode to the nearest one that was not measured, in half-power bandwidths.
double missing_distance(const Pairing& pairing, const ModelModes& model, const Pair& pair,
                        double loss_factor);

/// Why neither the modulus nor the loss factor can be had from this mode; nothing: they may be.
std::optional<std::string> distrust_both(const Mode& mode);
/// Why its modulus is not to be trusted, known with this relative standard error.
std::optional<std::string> distrust_modulus(double relative_sigma);
/// Why its loss factor is not; in bandwidths: `spread` of a group behind its pole, the `neighbour`'s
/// distance, which does not matter where `several_references` part the closest, and that of the nearest
/// `missing` model mode, which explains a second pole in the lines.
struct Surroundings {
  double spread = 0.0;
  double neighbour = 0.0;
  double missing = 0.0;
  bool several_references = false;
};
std::optional<std::string> distrust_loss_factor(const Pair& pair, const Mode& mode,
                                                const Surroundings& around);

/// Relative standard errors, with a model's `floor` added in square; of modes without their own, 0.5 % of E
/// and 5 % of eta.
double relative_modulus_sigma(const Pair& pair, const Mode& mode, double floor);
double relative_loss_factor_sigma(const Mode& mode, double floor);

}  // namespace struna::ident
