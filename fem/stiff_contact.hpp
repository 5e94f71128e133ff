#pragma once

#include <string>
#include <vector>

#include "fem/contact_geometry.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/model.hpp"
#include "fem/scene.hpp"

namespace struna::fem {

/// A contact's spring against what it acts on.
struct ContactStiffness {
  double between_nodes = 0.0;  ///< stiffness of a node of the inside body while its neighbours hold still,
                               ///< 192 EI/(2 l)^3, l the first element's length [N/m]
  double angular_frequency = 0.0;  ///< of the spring with the mass that a point shows to a blow [1/s]
  double restitution = 1.0;        ///< of a blow, from the law; hunt_crossley: of a slow one
};

/// A spring beyond this many times `between_nodes` measures the mesh, and is warned of.
constexpr double stiff_contact = 100.0;
/// Beyond this many, a blow is over in about a hundredth of the fastest period that the mesh has (the ratio
/// of frequencies is the root of that of stiffnesses): an impact as far as the model can tell, while every
/// bounce of it has to be followed. Such scenes are refused: docs/contact.md.
constexpr double rigid_contact = 1e4;

/// `modes` complete, of both bodies; the mass is the median over `pairs` (1/mass = sum of the modal
/// components along the stiffer of the plane's axes, squared). Without pairs only between_nodes is known.
ContactStiffness contact_stiffness(const Contact& contact, const std::vector<ContactPair>& pairs,
                                   const Model& inside, const Eigenmodes& inside_modes,
                                   const Eigenmodes& outside_modes, double highest_hz);

/// Throws Error, with the law that stands for it, where the contact's stiffness is beyond rigid_contact.
void refuse_rigid(const Contact& contact, const ContactStiffness& stiffness);

/// What is to be told of a stiffness beyond stiff_contact; empty below.
std::string stiffness_warning(const Contact& contact, const ContactStiffness& stiffness);

/// "FILE:LINE: contact of 'wire' in 'band'", without a file where none is known.
std::string contact_name(const Contact& contact);

}  // namespace struna::fem
