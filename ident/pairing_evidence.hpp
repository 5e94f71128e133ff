#pragma once

#include <vector>

#include "ident/pairing_cost.hpp"

namespace struna::ident {

inline constexpr double pair_frequency_scale =
    0.003;  ///< of a true pair about a power law: the model's error

/// How much more probable the measured modes are under a law and an assignment than if none of them were one
/// of the model's: ln of the ratio, the law's own uncertainty and the shares of missing and of spurious modes
/// integrated out (docs/pairing.md, "How probable is it?"). 0 without pairs. `explanation`: per measured
/// mode, -1 unpaired, as in PairingCost::Assignment. The search's range in `options` is the prior of the
/// modulus. `frequency_scale`: relative, of a true pair about the law; larger where the law is known coarsely
/// so far.
double pairing_evidence(const PairingCost& cost, const PairingCost::Law& law,
                        const std::vector<int>& explanation, const PairingOptions& options,
                        double frequency_scale = pair_frequency_scale);

/// Probability that a direction drawn at random in as many dimensions lies within this angle [rad] of
/// another: J(angle)/J(pi), J the integral of sin^(dimensions - 2).
double chance_of_angle(double angle, int dimensions);

}  // namespace struna::ident
