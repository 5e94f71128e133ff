#pragma once

#include <vector>

#include "ident/pairing_cost.hpp"

namespace struna::ident {

inline constexpr double pairing_tolerance =
    0.012;  ///< relative frequency: what a power law leaves of a modulus

/// An explanation of the whole list of modes, and how probable it is against chance.
struct Hypothesis {
  PairingCost::Law law;
  PairingCost::Assignment assignment;
  double evidence = 0.0;  ///< minus infinity without pairs: last to be taken, however probable chance is
};
/// Measured modes that are paired.
std::ptrdiff_t pair_count(const PairingCost::Assignment& assignment);

/// The basins of the cost over level and slope of the law (NLopt DIRECT-L and a sweep of the level, then
/// Sbplx from the best of them), the most probable one first. `options` as pair_modes has validated them.
std::vector<Hypothesis> search_hypotheses(const PairingCost& cost, const PairingOptions& options);

}  // namespace struna::ident
