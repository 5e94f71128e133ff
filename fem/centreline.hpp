#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace struna::fem {

/// A point of a space curve, by arc length s: position r [m], unit tangent dr/ds, curvature vector d2r/ds2
/// [1/m].
struct CurvePoint {
  Eigen::Vector3d position;
  Eigen::Vector3d tangent;
  Eigen::Vector3d curvature;
};

/// A smooth space curve parametrised by its arc length s in [0, length] [m]. A value: cheap to copy,
/// immutable.
class Centreline {
 public:
  class Curve;  ///< the curve behind it: straight, arc or spline (centreline.cpp)

  explicit Centreline(std::shared_ptr<const Curve> curve) : curve_(std::move(curve)) {}

  /// Arc length [m].
  double length() const;
  /// The curve at arc length s; s is held to [0, length] within rounding. Throws Error outside it.
  CurvePoint at(double s) const;
  /// True when the curve is one straight line: lets callers take the cheap way.
  bool is_straight() const;
  /// The same curve, scaled about its first point. Throws Error when the factor is not positive.
  Centreline scaled(double factor) const;

 private:
  std::shared_ptr<const Curve> curve_;
};

/// Straight line from `from` to `to` [m]. Throws Error when they coincide.
Centreline straight_line(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Circular arc in the x-y plane, starting at the origin along x and bending towards +y: `length` [m] over
/// `angle` [rad], 0 < angle < 2 pi.
Centreline circular_arc(double length, double angle);

/// Natural cubic spline in chord-length parameter through `points` [m] (de Boor, A Practical Guide to
/// Splines, ch. IV), scaled about its first point to `length` [m] when that is positive. Two points give a
/// straight line; so do collinear points in order. Throws Error on fewer than two points, coincident
/// neighbours or values that are not finite.
Centreline spline_through(const std::vector<Eigen::Vector3d>& points, double length = 0.0);

}  // namespace struna::fem
