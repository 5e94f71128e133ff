#include "fem/contact_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

void require(bool holds, const char* field, const char* rule, double value) {
  if (!holds) throw Error(fmt::format("contact law: {} must be {}, got {}", field, rule, value));
}

}  // namespace

ContactForceLaw contact_force_law(const Contact& contact) {
  if (!(contact.gap > 0.0) || !std::isfinite(contact.gap)) {
    throw Error(fmt::format("contact of '{}' in '{}': gap must be positive, got {} m", contact.inside,
                            contact.outside, contact.gap));
  }
  const ContactForceLaw law{contact.law, contact.stiffness, contact.damping, contact.gap,
                            contact.restitution};
  validate(law);
  return law;
}

void validate(const ContactForceLaw& law) {
  require(law.stiffness > 0.0 && std::isfinite(law.stiffness), "stiffness", "positive", law.stiffness);
  require(law.damping >= 0.0 && std::isfinite(law.damping), "damping", "zero or positive", law.damping);
  if (law.kind == ContactLaw::hunt_crossley) {
    require(law.damping_length > 0.0 && std::isfinite(law.damping_length), "damping_length", "positive",
            law.damping_length);
  }
  if (law.kind == ContactLaw::hard_stop) {
    require(law.restitution >= 0.0 && law.restitution <= 1.0, "restitution", "between 0 and 1",
            law.restitution);
  }
}

double dashpot(const ContactForceLaw& law, double penetration) {
  return law.kind == ContactLaw::hunt_crossley ? law.damping / law.damping_length * penetration : law.damping;
}

double spring_and_dashpot(const ContactForceLaw& law, double penetration, double rate) {
  return law.stiffness * penetration + dashpot(law, penetration) * rate;
}

double spring_and_dashpot_slope(const ContactForceLaw& law, double rate) {
  // The dashpot is constant or proportional to g.
  return law.stiffness + (dashpot(law, 1.0) - dashpot(law, 0.0)) * rate;
}

double spring_energy(const ContactForceLaw& law, double penetration) {
  return 0.5 * law.stiffness * penetration * penetration;
}

double contact_force(const ContactForceLaw& law, double penetration, double rate) {
  if (penetration <= 0.0) return 0.0;
  if (law.kind == ContactLaw::approach) return spring_and_dashpot(law, penetration, std::max(rate, 0.0));
  return std::max(0.0, spring_and_dashpot(law, penetration, rate));
}

double approach_restitution(double damping_ratio) {
  const double z = damping_ratio;
  require(z >= 0.0, "damping ratio", "zero or positive", z);
  // Compression ends at x' = 0 after the time acos(z)/(s w) with the depth (v/w) exp(-(z/s) acos z); the
  // spring alone gives all of that depth back. acos(z)/s and acosh(z)/r both tend to 1 at z = 1.
  if (std::abs(z - 1.0) < 1e-8) return std::exp(-1.0);
  if (z < 1.0) return std::exp(-z / std::sqrt(1.0 - z * z) * std::acos(z));
  return std::exp(-z / std::sqrt(z * z - 1.0) * std::acosh(z));
}

double no_adhesion_restitution(double damping_ratio) {
  const double z = damping_ratio;
  require(z >= 0.0, "damping ratio", "zero or positive", z);
  if (std::abs(z - 1.0) < 1e-8) return std::exp(-2.0);
  if (z < 1.0) {
    const double s = std::sqrt(1.0 - z * z);
    return std::exp(-z / s * std::atan2(2.0 * z * s, 2.0 * z * z - 1.0));
  }
  const double r = std::sqrt(z * z - 1.0);
  // (z + r)/(z - r) = (z + r)^2, because (z + r)(z - r) = 1.
  return std::exp(-2.0 * z / r * std::log(z + r));
}

double hunt_crossley_restitution(double relative_damping) {
  const double x = relative_damping;
  require(x >= 0.0 && std::isfinite(x), "relative damping c v/(k l)", "zero or positive", x);
  if (x < 1e-4) return 1.0 - x * (2.0 / 3.0 - 4.0 / 9.0 * x);  // next term O(x^3); avoids 0/0
  // With y = e x: -y - ln(1 - y) = x - ln(1 + x), 0 < y < min(x, 1); Newton held in its bracket.
  const double target = x - std::log1p(x);
  double lo = 0.0;
  double hi = std::min(x, 1.0);
  double y = 0.5 * hi;
  for (int k = 0; k < 200; ++k) {
    const double residual = -y - std::log1p(-y) - target;
    (residual > 0.0 ? hi : lo) = y;
    double next = y - residual * (1.0 - y) / y;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    if (std::abs(next - y) <= 1e-16 * y) break;
    y = next;
  }
  return y / x;
}

}  // namespace struna::fem
