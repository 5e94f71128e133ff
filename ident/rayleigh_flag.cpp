#include "ident/rayleigh_flag.hpp"

namespace struna::ident {

RayleighFlag rayleigh_flag(const RayleighFit& fit) {
  if (!fit.determined) return RayleighFlag::one_mode;
  if (fit.misfit > contradicted_misfit && fit.chance < contradicted_chance) return RayleighFlag::contradicted;
  return fit.rms == 0.0 ? RayleighFlag::two_modes : RayleighFlag::none;  // no degree of freedom
}

std::string to_string(RayleighFlag flag) {
  switch (flag) {
    case RayleighFlag::two_modes:
      return "two_modes";
    case RayleighFlag::contradicted:
      return "contradicted";
    case RayleighFlag::one_mode:
      return "one_mode";
    case RayleighFlag::none:
      break;
  }
  return "";
}

}  // namespace struna::ident
