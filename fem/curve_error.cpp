#include "fem/curve_error.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "fem/curve_shape.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"
#include "fem/rounded_polygon.hpp"
#include "fem/smooth_curve.hpp"

namespace struna::fem {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr int draws = 16;
constexpr int fewest_elements = 40, most_elements = 160;
constexpr double elements_per_radian = 4.0;
constexpr double mesh_error = 1e-4;    // of the sixth frequency with the fewest elements: no distance is less
constexpr double corner_radius = 2.0;  // thicknesses, of a tight bend

/// Relative frequencies: sqrt(lambda) of the first elastic modes.
Eigen::ArrayXd frequencies(Body body, Centreline centreline, int elements) {
  body.centreline = std::move(centreline);
  body.start_support = body.end_support = {};
  constexpr int most_rigid = 6;
  const bool held = body.start == EndCondition::clamped || body.end == EndCondition::clamped;
  const int count = held ? curve_modes : curve_modes + most_rigid;  // two pins leave a swing about the chord
  const Eigen::VectorXd all = solve_eigenmodes(assemble(body, elements), count).eigenvalue;
  return all.segment(rigid_modes(body, all), curve_modes).array().sqrt();
}

/// Where the line from a to b, lengthened, comes nearest to that from d to c; nothing where it does not
/// before them.
std::optional<Eigen::Vector3d> meeting(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = (b - a).normalized(), v = (c - d).normalized(), w = c - b;
  const double cosine = u.dot(v), sine2 = 1.0 - cosine * cosine;
  if (!(sine2 > 1e-6)) return std::nullopt;
  const double along_u = (w.dot(u) - cosine * w.dot(v)) / sine2;
  const double along_v = (cosine * w.dot(u) - w.dot(v)) / sine2;
  // Nearly parallel lines meet far away, at no bend of this wire.
  constexpr double farthest = 3.0;  // chords
  if (!(along_u > 0.0 && along_v > 0.0 && std::max(along_u, along_v) < farthest * w.norm()))
    return std::nullopt;
  return 0.5 * (b + along_u * u + c + along_v * v);
}

/// The points with the i-th and the next replaced by where the lines on either side meet; nothing where they
/// do not.
std::optional<Points> bent_between(const Points& points, std::size_t i) {
  if (i + 2 >= points.size()) return std::nullopt;
  const auto corner = meeting(points[i - 1], points[i], points[i + 1], points[i + 2]);
  if (!corner) return std::nullopt;
  Points other = points;
  other[i] = *corner;
  other.erase(other.begin() + static_cast<long>(i) + 1);
  return other;
}

/// Relative distance of the frequencies from those of tight bends at the polygons' corners: the largest of
/// each.
Eigen::ArrayXd corner_distance(const Body& body, const std::vector<Points>& polygons, double length) {
  const Eigen::ArrayXd drawn = frequencies(body, body.centreline, fewest_elements);
  Eigen::ArrayXd distance = Eigen::ArrayXd::Constant(curve_modes, mesh_error);
  for (const Points& polygon : polygons) {
    Centreline bent = rounded_polygon(polygon, corner_radius * thickness(body.section));
    if (length > 0.0) bent = bent.scaled(length / bent.length());
    distance = distance.max((drawn / frequencies(body, bent, 2 * fewest_elements) - 1.0).abs());
  }
  return distance;
}

/// Of points that draw the curve.
CurveError drawn_error(const Body& body, const Points& points, double length) {
  std::vector<Points> polygons{points};
  for (std::size_t i = 1; i + 2 < points.size(); ++i)
    if (const auto other = bent_between(points, i)) polygons.push_back(*other);
  CurveError error;
  error.sigma = corner_distance(body, polygons, length);
  error.worst = error.sigma.maxCoeff();
  return error;
}

/// `error` where a bend lies between the points: at least as far as a tight bend there, and just that where
/// the other points lie so straight that they cannot scatter.
CurveError bent_error(const Body& body, const Points& points, double length, const LoneBend& bend,
                      CurveError error) {
  constexpr double straight = 1e-3;  // rad
  const auto between = bent_between(points, static_cast<std::size_t>(bend.point));
  const Eigen::ArrayXd distance = corner_distance(body, {between.value_or(points)}, length);
  const double worst = distance.maxCoeff();
  // Nothing tells the bend's radius: any error between none and that of a tight bend is alike.
  const double beyond = std::max(0.0, 1.0 - curve_tolerance / std::max(worst, curve_tolerance));
  if (bend.rest < straight) return {distance, worst, beyond, 0.0, 0.0, true};
  error.sigma = error.sigma.max(distance);
  error.worst = std::max(error.worst, worst);
  error.probability = std::max(error.probability, beyond);
  return error;
}

/// Of points that were read off the curve, but for a bend between them.
CurveError smooth_error(const Body& body, const Points& points, double length) {
  const CurvesThroughPoints curves = curves_through(points, draws);
  const int fine =
      std::clamp(static_cast<int>(elements_per_radian * curves.turn), fewest_elements, most_elements);
  // Differences between smooth curves do with half the elements.
  const int coarse = fine / 2;
  const Centreline best = centreline_along(curves.likeliest, length);
  const Eigen::ArrayXd off = frequencies(body, body.centreline, fine) / frequencies(body, best, fine);
  const Eigen::ArrayXd likeliest = frequencies(body, best, coarse);
  CurveError error;
  error.digitised = true;
  error.scatter = curves.likeliest.scatter;
  error.radius = smallest_radius(best);
  Eigen::ArrayXd square = Eigen::ArrayXd::Zero(curve_modes);
  double worst_square = 0.0;
  int beyond = 0;
  for (const SmoothCurve& curve : curves.drawn) {
    const Eigen::ArrayXd one =
        (off * likeliest / frequencies(body, centreline_along(curve, length), coarse) - 1.0).abs();
    const double worst = one.maxCoeff();
    square += one.square();
    worst_square += worst * worst;
    beyond += worst > curve_tolerance;
  }
  error.sigma = (square / draws).sqrt();
  error.worst = std::sqrt(worst_square / draws);
  error.probability = static_cast<double>(beyond) / draws;
  return error;
}

}  // namespace

CurveError curve_error(const Body& body, const Points& points, double length) {
  if (body.centreline.is_straight()) return {};
  if (points.size() < fewest_digitised) return drawn_error(body, points, length);
  const CurveError error = smooth_error(body, points, length);
  const auto bend = lone_bend(points);
  return bend ? bent_error(body, points, length, *bend, error) : error;
}

}  // namespace struna::fem
