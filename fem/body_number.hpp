#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/eigenmodes.hpp"

namespace struna::fem {

/// The numbers that can be fitted beside a modulus: "torsion_constant"; "start.rotation",
/// "start.translation", "start.mass", the same of "end", and of "both" (one value for both ends).
std::vector<std::string> fittable_numbers();

/// Such a number of the body, sigma 0; a stiffness of a support that does not give is infinite, of "both" the
/// start's. Throws Error on another name, and where the body cannot have it (a free end's rotation).
BodyNumber fittable_number(const Body& body, const std::string& name);

/// The body with a number changed by `change`; a support's to number.value + change, a pinned end becoming a
/// clamped one that turns against the spring.
Body moved(Body body, const BodyNumber& number, double change);

/// d ln lambda/d number of each mode at unit modulus, from the Rayleigh quotient: phi^T (dK - lambda dM)
/// phi/lambda (Fox & Kapoor, AIAA J. 6 (1968) 2426, eq. 6), dK and dM by differences of the assembled
/// matrices. Of nearly double modes the mean is what counts. `model` is the mesh of its body, with which
/// `modes` were solved. Throws Error where the number is infinite.
Eigen::VectorXd log_eigenvalue_slopes(const Model& model, const Eigenmodes& modes, const BodyNumber& number);

}  // namespace struna::fem
