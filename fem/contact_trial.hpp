#pragma once

#include <cstddef>

namespace struna::fem {

/// How far beyond the first touch trials look [s]: trajectories have not parted yet.
inline constexpr double checked_beyond_touch = 0.02;

/// Thrown through trials when the user has had enough.
struct TrialInterrupted {};

/// Whether a stepper has touched any of so many contact points.
template <class Stepper>
bool touching(const Stepper& stepper, std::size_t points) {
  if (stepper.report().events > 0) return true;
  for (std::size_t i = 0; i < points; ++i)
    if (stepper.penetration(static_cast<int>(i)) > 0.0) return true;
  return false;
}

}  // namespace struna::fem
