#include "fem/contact_end_force.hpp"

#include <algorithm>
#include <cmath>

#include "fem/contact_solver.hpp"

namespace struna::fem {
namespace {

/// One contact at the end of a step, given all the others: g = g_free - w F, g' = g'_free - a1 w F.
struct ScalarContact {
  double g, rate, w, a1;
};

/// The force that meets the law. The dashpot's jump at touch is a step in the law: where the force would have
/// to lie inside it, the point ends on the wall (g = 0).
double scalar_force(const ContactForceLaw& law, const ScalarContact& s) {
  if (s.g <= 0.0) return 0.0;
  const double wall = s.g / s.w;
  const double k = law.stiffness;
  const double c = law.damping;
  if (law.kind == ContactLaw::hunt_crossley) {
    const auto excess = [&](double force) {
      return force - contact_force(law, s.g - s.w * force, s.rate - s.a1 * s.w * force);
    };
    double lo = 0.0;
    double hi = wall;
    for (int i = 0; i < 100 && hi - lo > 1e-15 * wall; ++i) {
      const double middle = 0.5 * (lo + hi);
      (excess(middle) > 0.0 ? hi : lo) = middle;
    }
    return 0.5 * (lo + hi);
  }
  const double damped = (k * s.g + c * s.rate) / (1.0 + (k + c * s.a1) * s.w);
  if (law.kind == ContactLaw::no_adhesion) return std::clamp(damped, 0.0, wall);
  if (s.rate - s.a1 * s.w * damped >= 0.0) return std::min(damped, wall);
  return k * s.g / (1.0 + k * s.w);
}

}  // namespace

bool solve_end_forces(const std::vector<ContactPoint>& points, const RowMatrix& flexibility,
                      double rate_factor, Eigen::VectorXd& offset, Eigen::VectorXd& rate,
                      Eigen::VectorXd& point_force, std::vector<double>& force) {
  const int count = static_cast<int>(points.size());
  point_force.setZero();
  std::fill(force.begin(), force.end(), 0.0);
  constexpr int most_sweeps = 2000;
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double change = 0.0;
    double largest = 0.0;
    for (int i = 0; i < count; ++i) {
      const ContactPoint& point = points[i];
      const double size = contact_distance(point.shape, &offset[2 * i], 2);
      if (force[i] == 0.0 && size <= point.gap) continue;
      const Eigen::Vector2d n = point.shape == StopShape::wall
                                    ? Eigen::Vector2d(Eigen::Vector2d::UnitX())
                                    : Eigen::Vector2d(offset.segment<2>(2 * i) / size);
      // The point with its own force taken away, to first order along its present normal.
      const Eigen::Vector2d own = point_force.segment<2>(2 * i);
      const Eigen::Matrix2d w_own = flexibility.block<2, 2>(2 * i, 2 * i);
      const ScalarContact scalar{size - point.gap - n.dot(w_own * own),
                                 n.dot(rate.segment<2>(2 * i) - rate_factor * (w_own * own)),
                                 n.dot(w_own * n), rate_factor};
      force[i] = scalar_force(point.law, scalar);
      const Eigen::Vector2d update = -force[i] * n - own;
      point_force.segment<2>(2 * i) += update;
      for (int d = 0; d < 2; ++d) {
        if (update[d] == 0.0) continue;
        offset += update[d] * flexibility.row(2 * i + d).transpose();
        rate += rate_factor * update[d] * flexibility.row(2 * i + d).transpose();
      }
      change = std::max(change, update.norm());
      largest = std::max(largest, force[i]);
    }
    if (change <= 1e-12 * largest) return true;
  }
  return false;
}

}  // namespace struna::fem
