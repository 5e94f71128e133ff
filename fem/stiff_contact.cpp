#include "fem/stiff_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// Velocity that a unit impulse gives the pair's offset [1/kg], along the axis that gives most.
double mobility(const ContactPair& pair, const Eigenmodes& inside, const Eigenmodes& outside) {
  const Eigen::MatrixX2d a = inside.shape.transpose() * pair.inside_weights;
  const Eigen::MatrixX2d b = outside.shape.transpose() * pair.outside_weights;
  return (a.colwise().squaredNorm() + b.colwise().squaredNorm()).maxCoeff();
}

double median_mobility(const std::vector<ContactPair>& pairs, const Eigenmodes& inside,
                       const Eigenmodes& outside) {
  std::vector<double> all;
  for (const ContactPair& pair : pairs) all.push_back(mobility(pair, inside, outside));
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

double blow_restitution(const Contact& contact, double damping_ratio) {
  switch (contact.law) {
    case ContactLaw::approach:
      return approach_restitution(damping_ratio);
    case ContactLaw::no_adhesion:
      return no_adhesion_restitution(damping_ratio);
    case ContactLaw::hunt_crossley:
      return 1.0;
    case ContactLaw::hard_stop:
      return contact.restitution;
  }
  throw Error("blow_restitution: unknown law");
}

/// Two digits, rounded down: a stiffness that is safely below the limit.
double round_down(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::floor(value / unit) * unit;
}

}  // namespace

ContactStiffness contact_stiffness(const Contact& contact, const std::vector<ContactPair>& pairs,
                                   const Model& inside, const Eigenmodes& inside_modes,
                                   const Eigenmodes& outside_modes, double highest_hz) {
  const Body& body = inside.body;
  const double h = inside.arc_length[1];
  const double bending = 192.0 * body.material.youngs_modulus.at(highest_hz) * body.section.second_moment;
  ContactStiffness found;
  found.between_nodes = bending / (8.0 * h * h * h);
  if (pairs.empty()) return found;
  const double per_mass = median_mobility(pairs, inside_modes, outside_modes);
  found.angular_frequency = std::sqrt(contact.stiffness * per_mass);
  found.restitution = blow_restitution(contact, 0.5 * contact.damping * per_mass / found.angular_frequency);
  return found;
}

std::string contact_name(const Contact& contact) {
  return fmt::format("{}contact of '{}' in '{}'", contact.place.empty() ? "" : contact.place + ": ",
                     contact.inside, contact.outside);
}

void refuse_rigid(const Contact& contact, const ContactStiffness& found) {
  if (!(contact.stiffness > rigid_contact * found.between_nodes)) return;
  const double enough = round_down(stiff_contact * found.between_nodes);
  const std::string cure =
      contact.law == ContactLaw::hard_stop
          ? fmt::format("with hard_stop it serves lasting contacts only: take stiffness = {:.2g}", enough)
          : fmt::format(
                "take law = \"hard_stop\" with restitution = {:.2g}, which it comes to, and stiffness "
                "= {:.2g} for contacts that last, or a softer wall",
                found.restitution, enough);
  const std::string what = fmt::format(
      "contact of '{}' in '{}': the stiffness of {:g} N/m is {:.2g} times that of '{}' between neighbouring "
      "nodes ({:.3g} N/m), more than {:g}: blows of {:.2g} s, which cannot be followed one by one; {}",
      contact.inside, contact.outside, contact.stiffness, contact.stiffness / found.between_nodes,
      contact.inside, found.between_nodes, rigid_contact,
      found.angular_frequency > 0.0 ? M_PI / found.angular_frequency : 0.0, cure);
  if (contact.place.empty()) throw Error("simulate: " + what);
  throw Error(contact.place, 0, what);
}

std::string stiffness_warning(const Contact& contact, const ContactStiffness& found) {
  if (!(contact.stiffness > stiff_contact * found.between_nodes)) return {};
  return fmt::format(
      "{}: the stiffness {:g} N/m is {:.0f} times that of '{}' between neighbouring nodes ({:.3g} N/m): in "
      "effect a rigid stop, whose penetration depends on the mesh{}",
      contact_name(contact), contact.stiffness, contact.stiffness / found.between_nodes, contact.inside,
      found.between_nodes,
      contact.law == ContactLaw::hard_stop
          ? ""
          : fmt::format("; law = \"hard_stop\" with restitution = {:.2g} does the same in less time",
                        found.restitution));
}

}  // namespace struna::fem
