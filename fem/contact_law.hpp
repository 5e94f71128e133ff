#pragma once

#include "fem/scene.hpp"

namespace struna::fem {

/// The normal force of one contact point, from penetration g = |h| - e > 0 [m] and its rate [m/s] (physics:
/// 17).
///
/// law             force [N]                          while
/// approach        k g + c max(g', 0)                 g > 0     (the paper's (16)-(17), read without memory)
/// no_adhesion     max(0, k g + c g')                 g > 0     (Schwager & Poeschel, Granul. Matter 9 (2007)
/// 465) hunt_crossley   max(0, k g + c (g/l) g')           g > 0     (Hunt & Crossley, J. Appl. Mech. 42
/// (1975) 440, n = 1) hard_stop       impulse, g'+ = -r g'-              at touch; contact that lasts:
/// no_adhesion with k, c
///
/// Hunt-Crossley's dashpot grows with the penetration; its coefficient is c at g = l, l = `damping_length`
/// (the gap, where a scene says nothing else), so that k and c keep their units.
struct ContactForceLaw {
  ContactLaw kind = ContactLaw::approach;
  double stiffness = 0.0;       ///< k [N/m]
  double damping = 0.0;         ///< c [N s/m]
  double damping_length = 1.0;  ///< l [m]; hunt_crossley only
  double restitution = 1.0;     ///< r [-]; hard_stop only
};

/// The law that a scene's contact asks for. Throws Error naming field, rule and value.
ContactForceLaw contact_force_law(const Contact& contact);

/// Throws Error unless k > 0, c >= 0, l > 0, 0 <= r <= 1.
void validate(const ContactForceLaw& law);

/// Coefficient of g' in the force at penetration g [N s/m]: c; hunt_crossley: c g/l.
double dashpot(const ContactForceLaw& law, double penetration);

/// k g + dashpot(g) g' [N], where the law lets both act.
double spring_and_dashpot(const ContactForceLaw& law, double penetration, double rate);

/// Its derivative with respect to g at constant g' [N/m].
double spring_and_dashpot_slope(const ContactForceLaw& law, double rate);

/// What the compressed spring holds, k g^2/2 [J].
double spring_energy(const ContactForceLaw& law, double penetration);

/// The law's force [N]; 0 for g <= 0.
double contact_force(const ContactForceLaw& law, double penetration, double rate);

/// Coefficient of restitution of a free mass m against the stop, at damping ratio zeta = c/(2 sqrt(k m)):
/// approach: exp(-(zeta/s) acos zeta), s = sqrt(1 - zeta^2); beyond 1 with acosh.
double approach_restitution(double damping_ratio);
/// no_adhesion, ends at zero force: exp(-(zeta/s) atan2(2 zeta s, 2 zeta^2 - 1)); beyond 1:
/// exp(-(zeta/r) ln((zeta + r)/(zeta - r))), r = sqrt(zeta^2 - 1)  (Schwager & Poeschel, Granul. Matter 9
/// (2007) 465).
double no_adhesion_restitution(double damping_ratio);
/// hunt_crossley with n = 1: x = c v/(k l), v the approach speed; e solves
/// x - ln(1 + x) = -e x - ln(1 - e x)  (Marhefka & Orin, IEEE Trans. SMC A 29 (1999) 566, integrated along
/// the path).
double hunt_crossley_restitution(double relative_damping);

}  // namespace struna::fem
