#pragma once

#include <string>

#include "ident/rayleigh_fit.hpp"

namespace struna::ident {

inline constexpr double contradicted_misfit = 0.05;   ///< of the damping ratio, and also
inline constexpr double contradicted_chance = 0.001;  ///< that noise makes the modes lie off so far

/// What cannot be trusted about the two coefficients together.
enum class RayleighFlag {
  none,
  two_modes,     ///< they go through two points exactly: no third one has said whether damping is like that
  contradicted,  ///< the modes lie off the curve by more than 5 % (misfit) and than noise would put them
  one_mode       ///< alpha is not known at all
};
RayleighFlag rayleigh_flag(const RayleighFit& fit);
/// That in words, for a terminal: "contradicted: the modes' damping lies 12 % off what they say"; "" for
/// none.
std::string caveat(const RayleighFit& fit);
std::string to_string(RayleighFlag flag);  ///< "two_modes", …; "" for none

}  // namespace struna::ident
