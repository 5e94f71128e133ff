#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/scene.hpp"
#include "ident/transfer_function.hpp"

namespace struna::apps {

/// Natural frequencies of a mesh that the program chooses are within this, relative.
constexpr double mesh_tolerance = 1e-5;

/// The body's elements, or as many as `highest_hz` needs where the scene leaves them open.
int mesh_elements(const fem::Body& body, double highest_hz);

/// A line for each law of the body that is used beyond the range of the data behind it.
std::vector<std::string> extrapolation_warnings(const fem::Body& body, fem::Damping damping,
                                                const Eigen::VectorXd& frequency_hz);

/// Linear response of the scene's driven and measured body over positive, increasing `frequency_hz`, one
/// output per measured direction. `form`: the kind wanted, unknown for the natural one (dynamic stiffness,
/// receptance, mobility, accelerance or transmissibility, by what drives and what is read). Throws Error
/// where it cannot be converted.
///
/// `worst_mesh_error`, when given, receives the largest estimated error of the mesh, relative to the outputs
/// at its line; it is estimated on at most 200 of the lines, evenly spread.
ident::TransferFunction predict(const fem::Scene& scene, fem::Damping damping,
                                const Eigen::VectorXd& frequency_hz, ident::FrfKind form,
                                double* worst_mesh_error = nullptr);

}  // namespace struna::apps
