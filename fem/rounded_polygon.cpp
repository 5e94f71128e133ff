#include "fem/rounded_polygon.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/centreline_curve.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr double most_of_line = 0.45;
constexpr double no_corner = 1e-9;  // rad

/// From `position` along `tangent`; an arc where `curvature` is not zero.
struct Piece {
  double s = 0.0;
  double length = 0.0;
  Vector3d position;
  Vector3d tangent;
  Vector3d curvature = Vector3d::Zero();

  CurvePoint at(double along) const {
    const double kappa = curvature.norm();
    if (!(kappa > 0.0)) return {position + along * tangent, tangent, curvature};
    const Vector3d inwards = curvature / kappa;
    const double angle = kappa * along, half = std::sin(0.5 * angle);
    return {position + (std::sin(angle) * tangent + 2.0 * half * half * inwards) / kappa,
            std::cos(angle) * tangent + std::sin(angle) * inwards,
            kappa * (std::cos(angle) * inwards - std::sin(angle) * tangent)};
  }
};

class Polygon final : public Centreline::Curve {
 public:
  Polygon(const Points& points, double radius) {
    Vector3d from = points.front();
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const Vector3d before = points[i] - points[i - 1], after = points[i + 1] - points[i];
      const Vector3d in = before.normalized(), out = after.normalized();
      const double angle = std::atan2(in.cross(out).norm(), in.dot(out));
      if (angle < no_corner) continue;
      if (angle > std::numbers::pi - 1e-6)
        throw Error(fmt::format("rounded_polygon: lines must not go straight back, as at point {}", i + 1));
      const double half = std::tan(0.5 * angle);
      const double cut = std::min(radius * half, most_of_line * std::min(before.norm(), after.norm()));
      const Vector3d start = points[i] - cut * in;
      add({0.0, (start - from).norm(), from, in});
      add({0.0, cut / half * angle, start, in, half / cut * (out - in * in.dot(out)).normalized()});
      from = points[i] + cut * out;
    }
    add({0.0, (points.back() - from).norm(), from, (points.back() - from).normalized()});
  }

  double length() const override { return pieces_.back().s + pieces_.back().length; }
  bool is_straight() const override { return pieces_.size() == 1; }
  CurvePoint at(double s) const override {
    auto piece = std::upper_bound(pieces_.begin() + 1, pieces_.end(), s,
                                  [](double value, const Piece& next) { return value < next.s; }) -
                 1;
    return piece->at(s - piece->s);
  }

 private:
  void add(Piece piece) {
    piece.s = pieces_.empty() ? 0.0 : length();
    pieces_.push_back(piece);
  }

  std::vector<Piece> pieces_;
};

}  // namespace

Centreline rounded_polygon(const Points& points, double radius) {
  if (points.size() < 2)
    throw Error(fmt::format("rounded_polygon: at least 2 points, got {}", points.size()));
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (!((points[i] - points[i - 1]).norm() > 0.0))
      throw Error(fmt::format("rounded_polygon: neighbouring points must differ, not {} and {}", i, i + 1));
  }
  if (!(radius > 0.0 && std::isfinite(radius)))
    throw Error(fmt::format("rounded_polygon: the radius must be positive, got {:g} m", radius));
  return Centreline(std::make_shared<Polygon>(points, radius));
}

}  // namespace struna::fem
