#include "fem/sized_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

constexpr long parts = 40;
constexpr int most_refinements = 2;

bool has_axial_part(const Eigen::Vector3d& direction, const Eigen::Vector3d& axis) {
  return std::abs(direction.dot(axis)) > 1e-6;
}

/// Of a straight body: driven along its axis, so that stretch waves run. What is read matters only where they
/// do.
bool drives_axis(const Body& body, const Drive& drive) {
  if (!body.centreline.is_straight()) return false;
  const Eigen::Vector3d axis = body.centreline.at(0.0).tangent;
  return std::visit([&](const auto& what) { return has_axial_part(what.direction, axis); }, drive);
}

/// Relative change to the neighbouring lines, per relative change of frequency, times f^2 as mesh errors
/// grow.
Eigen::VectorXd steepness_of(const HarmonicResponse& r) {
  const long lines = r.frequency_hz.size();
  Eigen::VectorXd steepness = Eigen::VectorXd::Zero(lines);
  for (long i = 0; i < lines; ++i) {
    const long before = std::max(i - 1, 0L), after = std::min(i + 1, lines - 1);
    const double size = r.response.row(i).norm(), f = r.frequency_hz(i);
    if (after == before || !(size > 0.0)) continue;
    steepness(i) = (r.response.row(after) - r.response.row(before)).norm() / size * f * f * f /
                   (r.frequency_hz(after) - r.frequency_hz(before));
  }
  return steepness;
}

/// The steepest line of each part of the band and its last one; every line where there are few.
std::vector<long> lines_to_check(const HarmonicResponse& r) {
  const long lines = r.frequency_hz.size();
  std::vector<long> chosen;
  if (lines <= 2 * parts) {
    for (long i = 0; i < lines; ++i) chosen.push_back(i);
    return chosen;
  }
  const Eigen::VectorXd steepness = steepness_of(r);
  for (long part = 0; part < parts; ++part) {
    const long first = part * lines / parts, end = (part + 1) * lines / parts;
    Eigen::Index steepest = 0;
    steepness.segment(first, end - first).maxCoeff(&steepest);
    chosen.push_back(first + steepest);
    if (steepest != end - 1 - first) chosen.push_back(end - 1);
  }
  return chosen;
}

double error_by_finer_mesh(const SizedResponse& sized, const Drive& drive, const Measurement& measurement,
                           Damping damping) {
  const std::vector<long> chosen = lines_to_check(sized.response);
  const Eigen::VectorXd frequency_hz = sized.response.frequency_hz(chosen);
  const HarmonicResponse finer = harmonic_response(assemble(sized.model.body, 2 * sized.mesh.elements), drive,
                                                   measurement, frequency_hz, {damping, false});
  const bool sure = is_sure(sized.model.body, sized.request);
  double worst = 0.0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const auto row = static_cast<long>(i);
    const double size = finer.response.row(row).norm();
    const double difference = (sized.response.response.row(chosen[i]) - finer.response.row(row)).norm();
    if (!(difference > 0.0)) continue;
    worst = std::max(worst, size > 0.0 ? error_from_difference(difference, sure) / size
                                       : std::numeric_limits<double>::infinity());
  }
  return worst;
}

bool is_damped(const Body& body, Damping damping, const MeshRequest& request) {
  return acting_loss_factor(body.material, damping, request.hi_hz) > 0.0;
}

}  // namespace

SizedResponse sized_response(const Body& body, const Drive& drive, const Measurement& measurement,
                             const Eigen::VectorXd& frequency_hz, Damping damping, double tolerance) {
  if (frequency_hz.size() == 0) throw Error("sized_response: at least one frequency is needed, got none");
  const MeshRequest request{.lo_hz = frequency_hz.minCoeff(),
                            .hi_hz = frequency_hz.maxCoeff(),
                            .tolerance = tolerance,
                            .target = SizingTarget::response,
                            .damping = damping,
                            .along_axis = drives_axis(body, drive)};
  MeshChoice mesh = choose_mesh(body, request);
  for (int refinements = 0;; ++refinements) {
    SizedResponse sized{assemble(body, mesh.elements), {}, request, mesh, 0.0, refinements};
    sized.response = harmonic_response(sized.model, drive, measurement, frequency_hz, {damping, false});
    sized.checked_error = error_by_finer_mesh(sized, drive, measurement, damping);
    const bool may_refine =
        body.elements == 0 && refinements < most_refinements && is_damped(body, damping, request);
    if (sized.checked_error <= tolerance || !may_refine) return sized;
    const int finer = refined_elements(mesh.elements, sized.checked_error, tolerance, is_sure(body, request));
    const MeshError expected = estimate_mesh_error(body, request, finer);
    if (finer <= mesh.elements || expected.rounding > sized.checked_error) return sized;
    mesh.elements = finer;
    mesh.error = expected;
    mesh.reason = MeshReason::checked;
  }
}

}  // namespace struna::fem
