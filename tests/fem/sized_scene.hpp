#pragma once

#include "fem/sized_response.hpp"
#include "tests/fem/random_scenes.hpp"

// What the choice of a mesh is worth: its error against a converged reference, and the coarsest mesh that
// would do.
namespace struna::fem::testing {

struct SizedOutcome {
  int elements = 0;              ///< chosen
  int fewest = 0;                ///< that meet the tolerance
  double error = 0.0;            ///< over the tolerance
  double reference_error = 0.0;  ///< of the reference itself, over the tolerance
  int checks = 0;                ///< responses solved again after a check
};

struct SizedScene {
  SizedOutcome frequency;
  SizedOutcome response;
};

constexpr long sized_lines = 120;

/// Natural frequencies up to the band's end against those of the reference; 1 where the mesh has too few.
inline double largest_deviation(const Eigen::VectorXd& f, const Eigen::VectorXd& reference, double hi_hz) {
  double largest = 0.0;
  for (long r = 0; r < reference.size() && reference(r) <= hi_hz; ++r) {
    if (r >= f.size()) return 1.0;
    largest = std::max(largest, std::abs(f(r) / reference(r) - 1.0));
  }
  return largest;
}

inline double largest_deviation(const Eigen::MatrixXcd& response, const Eigen::MatrixXcd& reference) {
  return ((response - reference).rowwise().norm().array() / reference.rowwise().norm().array()).maxCoeff();
}

/// Of `solve(elements)` and `deviation(values, reference)`: the reference has two and a half times the
/// chosen elements (at least), its own error follows from a mesh of two thirds of it. The fewest elements to
/// a part in sixteen.
template <class Solve, class Deviation>
SizedOutcome judge(int elements, double tolerance, Solve solve, Deviation deviation) {
  SizedOutcome outcome;
  outcome.elements = elements;
  const int fine = std::max(5 * elements / 2, 24);
  const auto reference = solve(fine);
  // Errors fall as h^2 at least: what is left of the difference to two thirds of the elements is 1/((3/2)^2 -
  // 1).
  outcome.reference_error = deviation(solve(fine * 2 / 3), reference) / 1.25 / tolerance;
  const auto error = [&](int n) { return deviation(solve(n), reference) / tolerance; };
  outcome.error = error(elements);
  int too_few = 1, enough = elements;
  while (enough - too_few > std::max(1, enough / 16)) {
    const int middle = (too_few + enough) / 2;
    (error(middle) <= 1.0 ? enough : too_few) = middle;
  }
  outcome.fewest = enough;
  return outcome;
}

inline SizedOutcome size_frequencies(const RandomScene& scene) {
  const MeshRequest request{.hi_hz = scene.hi_hz, .tolerance = scene.tolerance};
  // Two planes of bending, as many again for stretch and torsion.
  const double waves =
      std::pow(std::pow(2.0 * std::numbers::pi * scene.hi_hz, 2) /
                   scene.body.material.youngs_modulus.at(scene.hi_hz) / clamped_eigenvalue(scene.body),
               0.25);
  const int modes = 8 + static_cast<int>(3.4 * waves);
  return judge(
      choose_mesh(scene.body, request).elements, scene.tolerance,
      [&](int n) {
        return natural_frequencies_hz(scene.body,
                                      solve_eigenmodes(assemble(scene.body, n), modes).eigenvalue);
      },
      [&](const Eigen::VectorXd& f, const Eigen::VectorXd& reference) {
        return largest_deviation(f, reference, scene.hi_hz);
      });
}

/// With the check on twice the elements, as predictions are made.
inline SizedOutcome size_response(const RandomScene& scene) {
  const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(sized_lines, scene.lo_hz, scene.hi_hz);
  const SizedResponse sized =
      sized_response(scene.body, scene.drive, scene.measurement, lines, scene.damping, scene.tolerance);
  SizedOutcome outcome = judge(
      sized.mesh.elements, scene.tolerance,
      [&](int n) {
        return harmonic_response(assemble(scene.body, n), scene.drive, scene.measurement, lines,
                                 {scene.damping, false})
            .response;
      },
      [](const Eigen::MatrixXcd& response, const Eigen::MatrixXcd& reference) {
        return largest_deviation(response, reference);
      });
  outcome.checks = sized.refinements;
  return outcome;
}

inline SizedScene size_scene(const RandomScene& scene) {
  return {size_frequencies(scene), size_response(scene)};
}

}  // namespace struna::fem::testing
