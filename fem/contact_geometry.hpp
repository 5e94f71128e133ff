#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "fem/contact_law.hpp"
#include "fem/model.hpp"

namespace struna::fem {

/// Arc lengths at which a curve cuts a plane, prepared for many planes: the curve is sampled once.
class PlaneCut {
 public:
  /// `samples` intervals of equal arc length; two cuts closer than one interval are seen as none.
  PlaneCut(const Centreline& curve, int samples);
  /// The cut nearest to `point` of the plane through it normal to `normal`; none when the plane misses the
  /// curve. Bracketed Newton in arc length, to rounding. A cut within rounding of an end of the curve counts.
  std::optional<double> nearest(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

 private:
  Centreline curve_;
  std::vector<Eigen::Vector3d> sample_;
  double interval_ = 0.0;
};

/// A possible contact point: a mesh node of the inside body and the point of the outside body's centreline in
/// the node's normal plane (19)-(24). The plane is normal to the inside centreline's tangent and needs
/// neither N nor B, so straight and inflected pieces are nothing special. Both centrelines are the smooth
/// curves, in the reference configuration.
///   h = rest_offset + inside_weights^T q_inside - outside_weights^T q_outside   (in the plane's two axes)
/// The force -F h/|h| on the inside body acts through the same weights (25)-(26), so contact work is
/// conjugate.
struct ContactPair {
  int node = 0;                     ///< of the inside body
  double inside_arc_length = 0.0;   ///< [m]
  double outside_arc_length = 0.0;  ///< [m]
  Eigen::Matrix<double, 3, 2> plane_axes =
      Eigen::Matrix<double, 3, 2>::Zero();                ///< orthonormal, normal to the tangent
  Eigen::Vector2d rest_offset = Eigen::Vector2d::Zero();  ///< x_inside - x_outside at rest, in the plane [m]
  Eigen::MatrixX2d inside_weights;                        ///< all dof of the inside model x 2
  Eigen::MatrixX2d outside_weights;                       ///< all dof of the outside model x 2
};

/// One pair per node of the inside body whose normal plane cuts the outside centreline; the nearest cut where
/// there are several; no pair where there is none, or where both sides are held by supports (nothing there
/// can give).
std::vector<ContactPair> contact_pairs(const Model& inside, const Model& outside);

/// Shape of a stop: the bore of a tube around the point, g = |h| - e, or a wall across the first axis, g =
/// h_1 - e.
enum class StopShape { bore, wall };

/// A possible contact point in the coordinates in which two bodies are stepped (modal or free nodal):
///   h = rest_offset + motion u(t) + inside^T x_inside - outside^T x_outside.
struct ContactPoint {
  ContactForceLaw law;
  double gap = 0.0;  ///< e [m]
  StopShape shape = StopShape::bore;
  int inside_body = 0;                                    ///< index of the stepper's body
  int outside_body = -1;                                  ///< -1: the ground
  Eigen::Vector2d rest_offset = Eigen::Vector2d::Zero();  ///< [m]
  Eigen::Vector2d motion = Eigen::Vector2d::Zero();       ///< dh/du of the prescribed motion u
  Eigen::MatrixX2d inside;                                ///< coordinates of the inside body x 2
  Eigen::MatrixX2d outside;                               ///< of the outside body x 2; empty for the ground
  std::string name = {};                                  ///< in messages; empty: "contact point 0"
};

/// What messages call points[index].
std::string point_name(const std::vector<ContactPoint>& points, std::size_t index);

/// Throws Error naming the point, field, rule and value; `coordinates` counts each body's.
void validate(const std::vector<ContactPoint>& points, const std::vector<int>& coordinates);

}  // namespace struna::fem
