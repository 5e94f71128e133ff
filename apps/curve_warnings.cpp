#include "apps/curve_warnings.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/eigenmodes.hpp"

namespace struna::apps {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr int stations = 600;
constexpr int elements = 40;
constexpr int modes = 6;
constexpr std::size_t fewest_to_halve = 12;

/// Sums of chords up to each point.
std::vector<double> chord_parameter(const Points& points) {
  std::vector<double> t{0.0};
  for (std::size_t i = 1; i < points.size(); ++i) t.push_back(t.back() + (points[i] - points[i - 1]).norm());
  return t;
}

/// Lagrange's weight at `at` of point j among those chosen.
double lagrange(const std::vector<double>& t, const std::vector<std::size_t>& chosen, std::size_t j,
                double at) {
  double weight = 1.0;
  for (const std::size_t k : chosen)
    if (k != j) weight *= (at - t[k]) / (t[j] - t[k]);
  return weight;
}

/// Inner points with two neighbours on either side, freed of their scatter.
Points smoothed(const Points& points) {
  const std::vector<double> t = chord_parameter(points);
  Points result = points;
  for (std::size_t i = 2; i + 2 < points.size(); ++i) {
    const std::vector<std::size_t> others = {i - 2, i - 1, i + 1, i + 2};
    Vector3d off = points[i];
    double own = 1.0;
    for (const std::size_t j : others) {
      const double weight = lagrange(t, others, j, t[i]);
      off -= weight * points[j];
      own += weight * weight;
    }
    result[i] -= off / own;
  }
  return result;
}

/// With one more between each two, on the cubic through the four nearest.
Points refined(const Points& points) {
  const std::vector<double> t = chord_parameter(points);
  const std::size_t width = std::min<std::size_t>(4, points.size());
  Points result{points.front()};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const std::size_t first = std::min(i < 2 ? 0 : i - 2, points.size() - width);
    std::vector<std::size_t> nearest;
    for (std::size_t k = 0; k < width; ++k) nearest.push_back(first + k);
    Vector3d between = Vector3d::Zero();
    for (const std::size_t j : nearest)
      between += lagrange(t, nearest, j, 0.5 * (t[i - 1] + t[i])) * points[j];
    result.push_back(between);
    result.push_back(points[i]);
  }
  return result;
}

/// The ends and every other inner point, from the first (0) or second (1) on.
Points half(const Points& points, std::size_t from) {
  Points result{points.front()};
  for (std::size_t i = 1 + from; i + 1 < points.size(); i += 2) result.push_back(points[i]);
  result.push_back(points.back());
  return result;
}

Eigen::ArrayXd elastic_eigenvalues(fem::Body body) {
  body.start_support = body.end_support = {};
  const Eigen::VectorXd all = fem::solve_eigenmodes(fem::assemble(body, elements), modes + 6).eigenvalue;
  return all.segment(fem::rigid_modes(body, all), modes);
}

/// The chord, by its first point, that is so short beside both neighbours and so far off their direction that
/// it can only be the points' error; 0 where there is none.
std::size_t stray_chord(const Points& points) {
  constexpr double short_chord = 0.05, far_off = 0.2;  // of the neighbours; rad
  for (std::size_t i = 2; i + 1 < points.size(); ++i) {
    const Vector3d before = points[i - 1] - points[i - 2], chord = points[i] - points[i - 1],
                   after = points[i + 1] - points[i];
    if (chord.norm() > short_chord * std::min(before.norm(), after.norm())) continue;
    const Vector3d around = before.normalized() + after.normalized();
    if (chord.cross(around).norm() > std::sin(far_off) * chord.norm() * around.norm()) return i;
  }
  return 0;
}

/// Diameter of the solid circle with this radius of gyration.
double thickness(const fem::Section& section) {
  return 4.0 * std::sqrt(section.second_moment / section.area);
}

}  // namespace

double curve_doubt(const fem::Body& body, const Points& points, double length) {
  if (body.centreline.is_straight() || points.size() < fewest_digitised) return 0.0;
  const auto eigenvalues_through = [&](const Points& other_points) {
    fem::Body other = body;
    other.centreline = fem::spline_through(refined(other_points), length);
    return elastic_eigenvalues(other);
  };
  const auto change = [](const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
    return ((a / b).sqrt() - 1.0).abs().maxCoeff();
  };
  const double by_smoothing = change(eigenvalues_through(smoothed(points)), elastic_eigenvalues(body));
  if (points.size() < fewest_to_halve || by_smoothing > curve_tolerance) return by_smoothing;
  const double halves = change(eigenvalues_through(half(points, 0)), eigenvalues_through(half(points, 1)));
  return std::max(by_smoothing, 0.5 * halves);
}

double smallest_radius(const fem::Centreline& centreline) {
  if (centreline.is_straight()) return std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (int i = 0; i <= stations; ++i)
    largest = std::max(largest, centreline.at(centreline.length() * i / stations).curvature.norm());
  return 1.0 / largest;
}

std::vector<std::string> curve_warnings(const fem::Body& body, const Points& points, double length) {
  std::vector<std::string> warnings;
  const double doubt = curve_doubt(body, points, length);
  if (doubt > curve_tolerance)
    warnings.push_back(fmt::format(
        "of body '{}' leave open how the curve runs: another one through them, smoother at the points and "
        "not straight at its ends, moves natural frequencies by up to {:.2g} %; give more and truer points{}",
        body.name, 100.0 * doubt, length > 0.0 ? "" : ", and the length"));
  if (const std::size_t i = stray_chord(points); i > 0)
    warnings.push_back(fmt::format(
        "of body '{}' turn the curve aside where points {} and {} are too near each other, {:.2g} m apart: "
        "take one of them out",
        body.name, i, i + 1, (points[i] - points[i - 1]).norm()));
  const double radius = smallest_radius(body.centreline), thick = thickness(body.section);
  if (radius < tightest_bend * thick)
    warnings.push_back(fmt::format(
        "of body '{}' bend it to a radius of {:.2g} m, {:.2g} times its thickness: below {:g} times beam "
        "theory does not hold; is there a kink, or are points in the wrong order?",
        body.name, radius, radius / thick, tightest_bend));
  return warnings;
}

}  // namespace struna::apps
