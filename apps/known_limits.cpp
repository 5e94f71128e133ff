#include "apps/limit_contact.hpp"
#include "apps/limit_curves.hpp"
#include "apps/limit_damping.hpp"
#include "apps/limit_kinks.hpp"
#include "apps/limit_laws.hpp"
#include "apps/limit_modes.hpp"
#include "apps/limit_newmark.hpp"
#include "apps/limit_pairing.hpp"
#include "apps/limit_penalty.hpp"
#include "apps/limit_stepping.hpp"
#include "apps/limit_transfer.hpp"
#include "apps/limits.hpp"

namespace struna::apps {

std::vector<KnownLimit> known_limits() {
  return {{"leakage", leakage_limits},
          {"leakage_peak", leakage_peak_limits},
          {"local_model", local_model_limits},
          {"circle", circle_limits},
          {"modes", multi_mode_limits},
          {"pairing", pairing_limits},
          {"rayleigh", rayleigh_limits},
          {"extrapolation", extrapolation_limits},
          {"curves", curve_limits},
          {"kinks", kink_limits},
          {"near_points", near_point_limits},
          {"newmark", newmark_limits},
          {"newmark_parameters", newmark_parameter_limits},
          {"newmark_contact", newmark_contact_limits},
          {"modal_contact", modal_contact_limits},
          {"contact_tolerance", contact_tolerance_limits},
          {"stiff_wall", stiff_wall_limits},
          {"truncation", truncation_limits},
          {"damping_in_time", damping_in_time_limits},
          {"penalty", penalty_limits}};
}

}  // namespace struna::apps
