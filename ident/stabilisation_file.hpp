#pragma once

#include <string>

#include "ident/stabilisation.hpp"

namespace struna::ident {

/// CSV, a row a pole, ascending in frequency: `order [-],natural_frequency [Hz],loss_factor [-],stability,
/// column`. stability: new, f, f+eta or all (Stability); column counts the stable columns from 1, ascending
/// in frequency, empty where the pole is in none. Written atomically; throws Error when it cannot be.
void write_stabilisation(const Stabilisation& stabilisation, const std::string& file);

}  // namespace struna::ident
