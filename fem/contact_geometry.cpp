#include "fem/contact_geometry.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// Two unit vectors that make a right-handed frame with the unit tangent, without the curve's own normal:
/// the coordinate axis least along the tangent, made orthogonal. Coordinate axes stay what they are on a
/// straight wire.
Eigen::Matrix<double, 3, 2> axes_normal_to(const Eigen::Vector3d& tangent) {
  // Prefer y over z over x when they tie, so that the first axis of a wire along x is y.
  const double slack = 1e-6;
  int axis = 1;
  if (std::abs(tangent[2]) < std::abs(tangent[axis]) - slack) axis = 2;
  if (std::abs(tangent[0]) < std::abs(tangent[axis]) - slack) axis = 0;
  Eigen::Matrix<double, 3, 2> axes;
  const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
  axes.col(0) = (unit - unit.dot(tangent) * tangent).normalized();
  axes.col(1) = tangent.cross(axes.col(0));
  return axes;
}

bool held_in_translation(const Model& model, const Eigen::MatrixX2d& weights) {
  for (int dof : model.free_dof) {
    if (weights.row(dof).cwiseAbs().maxCoeff() > 0.0) return false;
  }
  return true;
}

Eigen::MatrixX2d displacement_weights(const Model& model, double arc_length,
                                      const Eigen::Matrix<double, 3, 2>& axes) {
  const double fraction = std::clamp(arc_length / model.body.centreline.length(), 0.0, 1.0);
  Eigen::MatrixX2d weights(model.dof_count(), 2);
  for (int k = 0; k < 2; ++k) weights.col(k) = point_functional(model, fraction, axes.col(k));
  return weights;
}

/// A node's own displacement: exact, and free of the rounding in fraction = s/length.
Eigen::MatrixX2d node_weights(const Model& model, int node, const Eigen::Matrix<double, 3, 2>& axes) {
  Eigen::MatrixX2d weights = Eigen::MatrixX2d::Zero(model.dof_count(), 2);
  weights.middleRows(model.node_dof(node), 3) = axes;
  return weights;
}

}  // namespace

PlaneCut::PlaneCut(const Centreline& curve, int samples) : curve_(curve) {
  if (samples < 1) throw Error(fmt::format("PlaneCut: at least 1 interval, got {}", samples));
  interval_ = curve.length() / samples;
  for (int i = 0; i <= samples; ++i) {
    sample_.push_back(curve.at(std::min(i * interval_, curve.length())).position);
  }
}

std::optional<double> PlaneCut::nearest(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  const double length = curve_.length();
  const double rounding = 1e-12 * length;  // positions carry a few rounding errors of their own size
  const auto distance = [&](const Eigen::Vector3d& x) { return (x - point).dot(normal); };
  std::optional<double> best;
  double best_offset = 0.0;
  const auto consider = [&](double s) {
    const double offset = (curve_.at(s).position - point).norm();
    if (!best || offset < best_offset) {
      best = s;
      best_offset = offset;
    }
  };
  if (std::abs(distance(sample_.front())) <= rounding) consider(0.0);
  if (std::abs(distance(sample_.back())) <= rounding) consider(length);
  for (std::size_t i = 0; i + 1 < sample_.size(); ++i) {
    double left = distance(sample_[i]);
    const double right = distance(sample_[i + 1]);
    if (left == 0.0) consider(static_cast<double>(i) * interval_);
    if (!(left * right < 0.0)) continue;
    // Newton, kept inside the bracket by bisection.
    double lo = static_cast<double>(i) * interval_;
    double hi = std::min(lo + interval_, length);
    double s = lo + (hi - lo) * left / (left - right);
    for (int k = 0; k < 100; ++k) {
      const CurvePoint at = curve_.at(s);
      const double f = distance(at.position);
      if (f == 0.0) break;
      (f * left > 0.0 ? lo : hi) = s;
      double next = s - f / at.tangent.dot(normal);
      if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
      const bool settled = std::abs(next - s) <= 1e-15 * length;
      s = next;
      if (settled) break;
    }
    consider(s);
  }
  return best;
}

std::vector<ContactPair> contact_pairs(const Model& inside, const Model& outside) {
  const int outside_elements = static_cast<int>(outside.arc_length.size()) - 1;
  const PlaneCut cut(outside.body.centreline, std::max(256, 8 * outside_elements));
  std::vector<ContactPair> pairs;
  for (std::size_t i = 0; i < inside.arc_length.size(); ++i) {
    ContactPair pair;
    pair.node = static_cast<int>(i);
    pair.inside_arc_length = inside.arc_length[i];
    const CurvePoint at = inside.body.centreline.at(pair.inside_arc_length);
    const std::optional<double> outside_s = cut.nearest(at.position, at.tangent);
    if (!outside_s) continue;
    pair.outside_arc_length = *outside_s;
    pair.plane_axes = axes_normal_to(at.tangent);
    pair.rest_offset =
        pair.plane_axes.transpose() * (at.position - outside.body.centreline.at(*outside_s).position);
    pair.inside_weights = node_weights(inside, pair.node, pair.plane_axes);
    pair.outside_weights = displacement_weights(outside, *outside_s, pair.plane_axes);
    if (held_in_translation(inside, pair.inside_weights) &&
        held_in_translation(outside, pair.outside_weights)) {
      continue;
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

std::string point_name(const std::vector<ContactPoint>& points, std::size_t index) {
  return points[index].name.empty() ? fmt::format("contact point {}", index) : points[index].name;
}

void validate(const std::vector<ContactPoint>& points, const std::vector<int>& coordinates) {
  const int bodies = static_cast<int>(coordinates.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ContactPoint& point = points[i];
    const auto fail = [&](const std::string& what) {
      throw Error(fmt::format("{}: {}", point_name(points, i), what));
    };
    validate(point.law);
    if (!(point.gap > 0.0) || !std::isfinite(point.gap)) {
      fail(fmt::format("gap must be positive, got {} m", point.gap));
    }
    if (point.inside_body < 0 || point.inside_body >= bodies) {
      fail(fmt::format("inside_body must be one of {} bodies, got {}", bodies, point.inside_body));
    }
    if (point.outside_body < -1 || point.outside_body >= bodies) {
      fail(fmt::format("outside_body must be -1 or one of {} bodies, got {}", bodies, point.outside_body));
    }
    if (point.inside_body == point.outside_body) fail("inside_body and outside_body must differ");
    const int inside = coordinates[point.inside_body];
    if (point.inside.rows() != inside) {
      fail(fmt::format("inside must have {} rows, got {}", inside, point.inside.rows()));
    }
    const int outside = point.outside_body < 0 ? 0 : coordinates[point.outside_body];
    if (point.outside.rows() != outside) {
      fail(fmt::format("outside must have {} rows, got {}", outside, point.outside.rows()));
    }
    if (!point.rest_offset.allFinite() || !point.motion.allFinite() || !point.inside.allFinite() ||
        !point.outside.allFinite()) {
      fail("rest_offset, motion, inside and outside must be finite");
    }
  }
}

}  // namespace struna::fem
