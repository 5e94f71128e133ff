#include "apps/tradeoff_linear.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/predict.hpp"
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

struct Solution {
  Eigen::VectorXd frequency_hz;
  Eigen::MatrixXcd response;
};

Solution solve(const LinearProblem& problem, int elements, int modes, const Eigen::VectorXd& lines) {
  const fem::Model model = fem::assemble(problem.body, elements);
  return {fem::natural_frequencies_hz(problem.body, fem::solve_eigenmodes(model, modes).eigenvalue),
          fem::harmonic_response(model, problem.drive, problem.measurement, lines, {problem.damping, false})
              .response};
}

template <class Values>
Values extrapolated(const Values& coarse, const Values& fine) {
  return (16.0 * fine - coarse) / 15.0;
}

/// Modes up to the band's end, by the finest mesh.
int modes_in_band(const LinearProblem& problem, int elements) {
  const fem::Model model = fem::assemble(problem.body, elements);
  for (int count = 16;; count *= 2) {
    const Eigen::VectorXd f =
        fem::natural_frequencies_hz(problem.body, fem::solve_eigenmodes(model, count).eigenvalue);
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

int default_elements(const LinearProblem& problem) {
  return mesh_elements(problem.body, problem.band.hi_hz);
}

LinearReference linear_reference(const LinearProblem& problem, long lines) {
  const int elements =
      std::max(fem::recommended_elements(problem.body, problem.band.hi_hz, mesh_tolerance), 12);
  LinearReference reference;
  reference.line_hz = Eigen::VectorXd::LinSpaced(lines, problem.band.lo_hz, problem.band.hi_hz);
  const int modes = modes_in_band(problem, elements);
  if (modes == 0) {
    throw Error(fmt::format("tradeoff: {} has no natural frequency up to {:g} Hz; a wider band", problem.name,
                            problem.band.hi_hz));
  }
  const Solution half = solve(problem, elements / 2, modes, reference.line_hz);
  const Solution coarse = solve(problem, elements / 2 * 2, modes, reference.line_hz);
  const Solution fine = solve(problem, elements / 2 * 4, modes, reference.line_hz);
  reference.natural_frequency_hz = extrapolated(coarse.frequency_hz, fine.frequency_hz);
  reference.response = extrapolated(coarse.response, fine.response);
  reference.frequency_error =
      frequency_error(extrapolated(half.frequency_hz, coarse.frequency_hz), reference.natural_frequency_hz) /
      16.0;
  reference.response_error =
      response_error(extrapolated(half.response, coarse.response), reference.response) / 16.0;
  reference.text = fmt::format(
      "extrapolated from {} and {} elements; the same from {} and {} differs by 16 times "
      "the error that is stated",
      elements / 2 * 2, elements / 2 * 4, elements / 2, elements / 2 * 2);
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
