#include "fem/curve_shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr int stations = 600;
constexpr double hardly = 0.05;

}  // namespace

double smallest_radius(const Centreline& centreline) {
  if (centreline.is_straight()) return std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (int i = 0; i <= stations; ++i)
    largest = std::max(largest, centreline.at(centreline.length() * i / stations).curvature.norm());
  return 1.0 / largest;
}

double thickness(const Section& section) {
  return 4.0 * std::sqrt(section.second_moment / section.area);
}

std::vector<double> turns(const Points& points) {
  std::vector<double> result;
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vector3d in = points[i] - points[i - 1], out = points[i + 1] - points[i];
    result.push_back(std::atan2(in.cross(out).norm(), in.dot(out)));
  }
  return result;
}

int stray_pair(const Points& points) {
  constexpr double far_off = 0.2;  // rad
  for (std::size_t i = 2; i + 1 < points.size(); ++i) {
    const Vector3d before = points[i - 1] - points[i - 2], chord = points[i] - points[i - 1],
                   after = points[i + 1] - points[i];
    if (chord.norm() > hardly * std::min(before.norm(), after.norm())) continue;
    const Vector3d around = before.normalized() + after.normalized();
    if (chord.cross(around).norm() > std::sin(far_off) * chord.norm() * around.norm())
      return static_cast<int>(i) - 1;
  }
  return -1;
}

int straight_beside_bend(const Points& points) {
  const std::vector<double> turn = turns(points);
  for (std::size_t i = 0; i < turn.size(); ++i) {
    const double before = i > 0 ? turn[i - 1] : 0.0, after = i + 1 < turn.size() ? turn[i + 1] : 0.0;
    if (turn[i] < hardly * std::max(before, after)) return static_cast<int>(i) + 1;
  }
  return -1;
}

std::optional<LoneBend> lone_bend(const Points& points) {
  constexpr double outstanding = 10.0, all_but = 0.2;
  const std::vector<double> turn = turns(points);
  if (turn.size() < 4) return std::nullopt;
  std::vector<double> sorted = turn;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<long>(sorted.size() / 2), sorted.end());
  const double median = sorted[sorted.size() / 2];
  const auto at = [&](std::size_t i) { return i < turn.size() ? turn[i] : 0.0; };  // -1 is beyond all
  std::size_t best = 0;
  for (std::size_t i = 0; i + 1 < turn.size(); ++i)
    if (at(i) + at(i + 1) > at(best) + at(best + 1)) best = i;
  const double bend = at(best) + at(best + 1);
  const double around = at(best - 2) + at(best - 1) + at(best + 2) + at(best + 3);
  if (!(bend > outstanding * median && around < all_but * bend)) return std::nullopt;
  return LoneBend{static_cast<int>(best) + 1, median};
}

}  // namespace struna::fem
