#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "fem/scene.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/transfer_function.hpp"

namespace struna::apps {

/// Natural frequencies of a mesh that the program chooses are within this, relative.
constexpr double mesh_tolerance = 1e-5;

/// The body's elements, or as many as `highest_hz` needs where the scene leaves them open.
int mesh_elements(const fem::Body& body, double highest_hz);

/// A line for each law of the body that is used beyond the range of the data behind it.
std::vector<std::string> extrapolation_warnings(const fem::Body& body, fem::Damping damping,
                                                const Eigen::VectorXd& frequency_hz);

/// Told when nothing damps the body: no loss factor (structural), no Rayleigh coefficient (viscous).
std::optional<std::string> undamped_warning(const fem::Body& body, fem::Damping damping);

/// What a reader of a prediction should know before it is made, a line each: laws used beyond their data, no
/// damping, contact left out.
std::vector<std::string> prediction_warnings(const fem::Scene& scene, fem::Damping damping,
                                             const Eigen::VectorXd& frequency_hz);

/// Told when the worst mesh error of a prediction, relative to its outputs, is above 1 %.
std::optional<std::string> mesh_warning(const fem::Body& body, const Eigen::VectorXd& frequency_hz,
                                        double worst_mesh_error);

/// Told when exponential windows added different decays [1/s] to the modes of two transfer functions that are
/// to be compared (TransferFunction::exponential_decay); a prediction is made without.
std::optional<std::string> window_warning(double measured_decay, double predicted_decay);

/// Linear response of the scene's driven and measured body over positive, increasing `frequency_hz`, one
/// output per measured direction. `form`: the kind wanted, unknown for the natural one (dynamic stiffness,
/// receptance, mobility, accelerance or transmissibility, by what drives and what is read). Throws Error
/// where it cannot be converted.
///
/// `worst_mesh_error`, when given, receives the largest estimated error of the mesh, relative to the outputs
/// at its line; it is estimated on at most 200 of the lines, evenly spread. `identified`, when given, is what
/// the body's laws come from: its covariance gives the outputs' sigma (ident/prediction_band.hpp).
ident::TransferFunction predict(const fem::Scene& scene, fem::Damping damping,
                                const Eigen::VectorXd& frequency_hz, ident::FrfKind form,
                                double* worst_mesh_error = nullptr,
                                const ident::IdentifiedParameters* identified = nullptr);

}  // namespace struna::apps
