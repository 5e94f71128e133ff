#pragma once

#include <string>

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
};

/// Throws Error naming body, field, rule and value. Young's modulus may be missing (a law without parameters or values)
/// until it is identified: the matrices, for unit modulus, do without it. validate_modulus() requires it.
void validate(const Body& body);
void validate_modulus(const Body& body);

/// Elements needed so that natural frequencies up to `highest_hz` are within `tolerance` (relative) by the
/// Hermite error (b L/n)^4/1440 of the straight beam, b^4 = rho A w^2/(E I); at least 8, and enough to follow
/// the curve.
int recommended_elements(const Body& body, double highest_hz, double tolerance);

}  // namespace struna::fem
