#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "fem/scene.hpp"
#include "fem/sizing.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/transfer_function.hpp"

namespace struna::apps {

/// The mesh of a prediction and what is known of its error.
struct PredictionMesh {
  fem::MeshRequest request;
  fem::MeshChoice choice;
  double checked_error = 0.0;  ///< found on a finer mesh, relative to the outputs on the worst line
  bool stated = false;         ///< the tolerance is the user's own
};

/// A line for each law of the body that is used beyond the range of the data behind it, with what the
/// standard error makes of it where `identified` (what the body's laws come from) is given.
std::vector<std::string> extrapolation_warnings(const fem::Body& body, fem::Damping damping,
                                                const Eigen::VectorXd& frequency_hz,
                                                const ident::IdentifiedParameters* identified = nullptr);

/// Told when nothing damps the body: no loss factor (structural), no Rayleigh coefficient (viscous).
std::optional<std::string> undamped_warning(const fem::Body& body, fem::Damping damping);

/// What a reader of a prediction should know before it is made, a line each: laws used beyond their data, no
/// damping, contact left out.
std::vector<std::string> prediction_warnings(const fem::Scene& scene, fem::Damping damping,
                                             const Eigen::VectorXd& frequency_hz,
                                             const ident::IdentifiedParameters* identified = nullptr);

/// Told when the mesh error of a prediction that was found is above the tolerance stated, or 1 % where none
/// is.
std::optional<std::string> mesh_warning(const PredictionMesh& mesh);

/// Told when exponential windows added different decays [1/s] to the modes of two transfer functions that are
/// to be compared (TransferFunction::exponential_decay); a prediction is made without.
std::optional<std::string> window_warning(double measured_decay, double predicted_decay);

/// Linear response of the scene's driven and measured body over positive, increasing `frequency_hz`, one
/// output per measured direction. `form`: the kind wanted, unknown for the natural one (dynamic stiffness,
/// receptance, mobility, accelerance or transmissibility, by what drives and what is read). Throws Error
/// where it cannot be converted.
///
/// The mesh is the body's own or follows from the scene's tolerance (fem/sized_response.hpp); `mesh`, when
/// given, receives it with its error. `identified`, when given, is what the body's laws come from: its
/// covariance gives the outputs' sigma (ident/prediction_band.hpp).
ident::TransferFunction predict(const fem::Scene& scene, fem::Damping damping,
                                const Eigen::VectorXd& frequency_hz, ident::FrfKind form,
                                PredictionMesh* mesh = nullptr,
                                const ident::IdentifiedParameters* identified = nullptr);

}  // namespace struna::apps
