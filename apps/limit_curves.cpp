#include "apps/limit_curves.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "apps/curve_warnings.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"

namespace struna::apps {
namespace {

constexpr int elements = 40;

fem::Body body_along(fem::Centreline centreline) {
  fem::Body body{"wire", std::move(centreline), fem::solid_circle(curve_diameter), 7650.0, 0.3, {}};
  body.material.youngs_modulus = fem::constant_law(1.2e11);
  return body;
}

/// Points of the arc, equally far apart, each off by a normal error in every direction; the ends are true, as
/// they are where the wire is clamped.
std::vector<Eigen::Vector3d> digitised(const fem::Centreline& arc, int count, double error, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d point = arc.at(arc.length() * i / (count - 1)).position;
    const bool inner = i > 0 && i + 1 < count;
    for (double& coordinate : point) coordinate += inner ? error * normal(engine) : 0.0;
    points.push_back(point);
  }
  return points;
}

}  // namespace

Eigen::VectorXd curve_eigenvalues(const fem::Centreline& centreline, int count) {
  return fem::solve_eigenmodes(fem::assemble(body_along(centreline), count), fem::curve_modes).eigenvalue;
}

void judge_curve(const std::vector<Eigen::Vector3d>& points, const Eigen::VectorXd& truth,
                 LimitTrial& trial) {
  trial.tolerance = fem::curve_tolerance;
  try {
    const fem::Body body = body_along(fem::spline_through(points));
    trial.error = ((curve_eigenvalues(body.centreline, elements).array() / truth.array()).sqrt() - 1.0)
                      .abs()
                      .maxCoeff();
    const CurveReport report = report_curve(body, points, 0.0);
    if (report.error.sigma.size() > 0) trial.sigma = report.error.worst;
    // A bend too tight for a beam is one, whatever a beam of that bend would do.
    const auto of_the_curve = [](const std::string& warning) {
      return warning.find("beam theory does not hold") == std::string::npos;
    };
    if (std::any_of(report.warnings.begin(), report.warnings.end(), of_the_curve)) trial.flags = "curve";
  } catch (const Error&) {
    trial.refused = true;
  }
}

LimitMap curve_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "curves";
  map.title = "Curve through digitised points of an arc";
  map.quantity = curve_quantity;
  map.fails = "a curve zigzags through scattered points, and too few do not tell it";
  map.sign = "curves that the points leave possible, and the natural frequencies along them";
  map.then = "states how far they are off, and warns of more than 0.5 %";
  map.axes = {run.axis("points [-]", {8, 12, 16, 24, 48, 96}),
              run.axis("error of a point [mm]", {0, 0.03, 0.1, 0.3, 1, 3}),
              run.axis("angle of the arc [rad]", {0.5, 1.5, 4.5})};
  for (const double angle : map.axes[2].values) {
    const fem::Centreline arc = fem::circular_arc(curve_length, angle);
    const Eigen::VectorXd truth = curve_eigenvalues(arc, elements);
    for_each_place({map.axes[0], map.axes[1]}, [&](const std::vector<double>& at) {
      for (const unsigned seed : run.draws(at[1] > 0.0 ? 5 : 1)) {
        LimitTrial trial;
        trial.at = {at[0], at[1], angle};
        trial.seed = seed;
        judge_curve(digitised(arc, static_cast<int>(at[0]), 1e-3 * at[1], seed), truth, trial);
        map.trials.push_back(std::move(trial));
      }
    });
  }
  return map;
}

}  // namespace struna::apps
