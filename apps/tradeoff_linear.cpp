#include "apps/tradeoff_linear.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/sizing.hpp"
#include "fem/error.hpp"

namespace struna::apps {
namespace {

LinearProblem wire_problem(const std::string& name, const fem::Centreline& centreline) {
  LinearProblem problem{name, {"wire", centreline, fem::solid_circle(0.0032), 7650.0, 0.3, {}}, {}, {}};
  problem.body.material.youngs_modulus = fem::constant_law(120e9);
  problem.body.material.loss_factor = fem::constant_law(0.02);
  problem.drive = fem::SupportMotion{{fem::End::start}, Eigen::Vector3d::UnitY()};
  problem.measurement = {fem::SupportForce{fem::End::end},
                         {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}};
  return problem;
}

Eigen::VectorXd frequencies(const LinearProblem& problem, int elements, int modes) {
  const fem::Model model = fem::assemble(problem.body, elements);
  return fem::natural_frequencies_hz(problem.body, fem::solve_eigenmodes(model, modes).eigenvalue);
}

Eigen::MatrixXcd response(const LinearProblem& problem, int elements, const Eigen::VectorXd& lines) {
  return fem::harmonic_response(fem::assemble(problem.body, elements), problem.drive, problem.measurement,
                                lines, {problem.damping, false})
      .response;
}

/// Of three meshes, each of twice the elements of the one before: the extrapolated solution, and the error of
/// it by `error_of(extrapolated from the coarser pair, extrapolated)`.
template <class Values, class Solve, class Error>
Values extrapolated(int elements, Solve solve, Error error_of, double& error) {
  const Values half = solve(elements / 2), coarse = solve(elements / 2 * 2), fine = solve(elements / 2 * 4);
  const Values rough = (16.0 * coarse - half) / 15.0;
  const Values result = (16.0 * fine - coarse) / 15.0;
  error = error_of(rough, result) / 16.0;
  return result;
}

int reference_elements(const LinearProblem& problem) {
  return std::max(fem::recommended_elements(problem.body, problem.band.hi_hz, frequency_tolerance), 12);
}

std::string reference_text(int elements) {
  return fmt::format(
      "extrapolated from {} and {} elements; the same from {} and {} differs by 16 times the error that is "
      "stated",
      elements / 2 * 2, elements / 2 * 4, elements / 2, elements / 2 * 2);
}

int modes_in_band(const LinearProblem& problem, int elements) {
  for (int count = 16;; count *= 2) {
    const Eigen::VectorXd f = frequencies(problem, elements, count);
    const auto below = static_cast<int>((f.array() <= problem.band.hi_hz).count());
    if (below < f.size() || f.size() < count) return below;
  }
}

}  // namespace

LinearProblem straight_wire_problem() {
  return wire_problem("straight wire", fem::straight_line({0, 0, 0}, {0.68, 0, 0}));
}

LinearProblem spline_wire_problem() {
  return wire_problem(
      "curved wire",
      fem::spline_through({{0, 0, 0}, {0.2, 0.05, 0}, {0.4, 0, 0.08}, {0.6, -0.05, 0.1}}, 0.68));
}

LinearProblem scene_problem(const fem::Scene& scene, const std::string& name, const Band& band) {
  const fem::LinearPath path = fem::linear_path(scene);
  return {name, path.body, path.drive, path.measurement, path.body.material.damping, band};
}

int default_elements(const LinearProblem& problem, fem::SizingTarget target) {
  const bool response = target == fem::SizingTarget::response;
  return fem::choose_mesh(problem.body, {.lo_hz = problem.band.lo_hz,
                                         .hi_hz = problem.band.hi_hz,
                                         .tolerance = response ? response_tolerance : frequency_tolerance,
                                         .target = target,
                                         .damping = problem.damping})
      .elements;
}

LinearReference response_reference(const LinearProblem& problem, long lines) {
  LinearReference reference;
  reference.line_hz = Eigen::VectorXd::LinSpaced(lines, problem.band.lo_hz, problem.band.hi_hz);
  const int elements = reference_elements(problem);
  reference.response = extrapolated<Eigen::MatrixXcd>(
      elements, [&](int n) { return response(problem, n, reference.line_hz); }, response_error,
      reference.response_error);
  reference.text = reference_text(elements);
  return reference;
}

LinearReference linear_reference(const LinearProblem& problem, long lines) {
  LinearReference reference = response_reference(problem, lines);
  const int elements = reference_elements(problem);
  const int modes = modes_in_band(problem, elements);
  if (modes == 0) {
    throw Error(fmt::format("tradeoff: {} has no natural frequency up to {:g} Hz; a wider band", problem.name,
                            problem.band.hi_hz));
  }
  reference.natural_frequency_hz = extrapolated<Eigen::VectorXd>(
      elements, [&](int n) { return frequencies(problem, n, modes); }, frequency_error,
      reference.frequency_error);
  return reference;
}

double frequency_error(const Eigen::VectorXd& natural_frequency_hz, const Eigen::VectorXd& reference) {
  if (natural_frequency_hz.size() < reference.size()) return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (long i = 0; i < reference.size(); ++i) {
    if (reference(i) > 0.0) worst = std::max(worst, std::abs(natural_frequency_hz(i) / reference(i) - 1.0));
  }
  return worst;
}

double response_error(const Eigen::MatrixXcd& response, const Eigen::MatrixXcd& reference) {
  const double largest = reference.colwise().norm().maxCoeff();
  double worst = 0.0;
  for (long k = 0; k < reference.cols(); ++k) {
    const double size = reference.col(k).norm();
    if (size > 1e-6 * largest) worst = std::max(worst, (response.col(k) - reference.col(k)).norm() / size);
  }
  return worst;
}

}  // namespace struna::apps
