#pragma once

#include <limits>
#include <string>
#include <vector>

#include "fem/centreline.hpp"
#include "fem/material.hpp"

namespace struna::fem {

/// Cross-section: area A [m^2], second moment I [m^4] (the same about both axes; effective for a strand),
/// torsion constant J [m^4]. The rotary inertia about the axis is that of a polar moment 2 I.
struct Section {
  double area = 0.0;
  double second_moment = 0.0;
  double torsion_constant = 0.0;
};

Section solid_circle(double diameter);                       ///< J = 2 I
Section ring(double outer_diameter, double inner_diameter);  ///< J = 2 I

enum class EndCondition { clamped, pinned, free };  ///< pinned: translations held, rotations free

/// How a held end gives way, the same in every direction. No clamp is rigid: much of what it gives is the
/// piece of the body inside it. The springs therefore follow the body's complex modulus over frequency: K =
/// E(f)(1 + i eta)(K1 + S/E0), the stiffnesses stated at E0 = E(support_reference_hz) (docs/supports.md).
struct ElasticSupport {
  double translation = std::numeric_limits<double>::infinity();  ///< [N/m] between the base and the end
  double rotation = std::numeric_limits<double>::infinity();  ///< [N m/rad] of a clamped end, twist included
  double mass = 0.0;  ///< [kg] that moves with the end, without rotary inertia

  bool gives_translation() const { return translation < std::numeric_limits<double>::infinity(); }
  bool gives_rotation() const { return rotation < std::numeric_limits<double>::infinity(); }
  bool gives() const { return gives_translation() || gives_rotation(); }
};
constexpr double support_reference_hz = 100.0;

/// A number that a scene states about a body, with its standard deviation, and what the body's properties
/// change by per unit of it. Numbers of supports ("start.rotation") are told by their name
/// (fem/body_number.hpp).
struct BodyNumber {
  std::string name;  ///< the scene's key, "diameter"
  double value = 0.0;
  double sigma = 0.0;  ///< 0: taken as exact
  Section section = {};
  double length = 0.0;
  double density = 0.0;
  double poisson = 0.0;
};

/// One slender body: everything the beam model is made from. SI units.
struct Body {
  std::string name;
  Centreline centreline;
  Section section;
  double density = 0.0;  ///< [kg/m^3]
  double poisson = 0.3;
  Material material;
  int elements = 0;  ///< 0: choose with recommended_elements()
  EndCondition start = EndCondition::clamped;
  EndCondition end = EndCondition::clamped;
  ElasticSupport start_support = {};  ///< of an end that is held; its mass of a free one too
  ElasticSupport end_support = {};
  std::vector<BodyNumber> stated = {};  ///< what it was made from; errors independent of each other
};

/// Whether a support gives way, so that the stiffness for unit modulus depends on the modulus.
bool has_elastic_support(const Body& body);

/// Throws Error naming body, field, rule and value. Young's modulus may be missing (a law without parameters
/// or values) until it is identified: the matrices, for unit modulus, do without it. validate_modulus()
/// requires it.
void validate(const Body& body);
void validate_modulus(const Body& body);

/// Elements needed so that natural frequencies up to `highest_hz` are within `tolerance` (relative) by the
/// Hermite error (b L/n)^4/1440 of the straight beam, b^4 = rho A w^2/(E I); at least 8, and enough to follow
/// the curve.
int recommended_elements(const Body& body, double highest_hz, double tolerance);

}  // namespace struna::fem
