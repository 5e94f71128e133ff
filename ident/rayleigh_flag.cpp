#include "ident/rayleigh_flag.hpp"

#include <fmt/format.h>

namespace struna::ident {

RayleighFlag rayleigh_flag(const RayleighFit& fit) {
  if (!fit.determined) return RayleighFlag::one_mode;
  if (fit.misfit > contradicted_misfit && fit.chance < contradicted_chance) return RayleighFlag::contradicted;
  return fit.rms == 0.0 ? RayleighFlag::two_modes : RayleighFlag::none;  // no degree of freedom
}

std::string caveat(const RayleighFit& fit) {
  switch (rayleigh_flag(fit)) {
    case RayleighFlag::one_mode:
      return "one frequency: beta alone";
    case RayleighFlag::two_modes:
      return "two modes: nothing has tested that damping follows alpha and beta";
    case RayleighFlag::contradicted:
      return fmt::format("contradicted: the modes' damping lies {:.0f} % off what they say",
                         100.0 * fit.misfit);
    case RayleighFlag::none:
      break;
  }
  return "";
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
