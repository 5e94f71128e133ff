#include "fem/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace struna::fem {
namespace {

/// A force and its derivatives with respect to the penetration at the end and at the start of the step.
struct ForceAndSlope {
  double force = 0.0;
  double slope = 0.0;
  double start_slope = 0.0;
};

double mean_penetration(const ClosedContact& c) {
  return 0.5 * (c.start_penetration + c.end_penetration);
}

/// Coefficient of g' in the force, at the mean penetration of the step [N s/m].
double mean_damping(const ClosedContact& c) {
  return c.phase == ContactPhase::unloading ? 0.0 : dashpot(*c.law, mean_penetration(c));
}

ForceAndSlope mean_force(const ClosedContact& c, double step) {
  const bool damped = c.phase != ContactPhase::unloading;
  const double rate = damped ? (c.end_penetration - c.prior_penetration) / step : 0.0;
  ForceAndSlope law;
  law.force = spring_and_dashpot(*c.law, mean_penetration(c), rate);
  // Over the mean penetration, in which the start and the end count half; the end moves the rate as well.
  law.start_slope = 0.5 * spring_and_dashpot_slope(*c.law, rate);
  law.slope = law.start_slope + mean_damping(c) / step;
  return law;
}

double dot(const double* a, const double* b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Unit direction of the penetration at an offset.
void unit_normal(const ClosedContact& c, const double* offset, int dimension, double* normal) {
  if (c.shape == StopShape::wall) {
    normal[0] = 1.0;
    normal[1] = 0.0;
    return;
  }
  const double size = contact_distance(c.shape, offset, dimension);
  for (int d = 0; d < dimension; ++d) normal[d] = size > 0.0 ? offset[d] / size : (d == 0 ? 1.0 : 0.0);
}

void end_normal(const ClosedContact& c, int dimension, double* normal) {
  unit_normal(c, c.end_offset, dimension, normal);
}

/// Direction of the discrete gradient over the step.
void mean_direction(ClosedContact& c, int dimension) {
  if (c.shape == StopShape::wall) return end_normal(c, dimension, c.direction);
  const double size = contact_distance(c.shape, c.start_offset, dimension) +
                      contact_distance(c.shape, c.end_offset, dimension);
  for (int d = 0; d < dimension; ++d) c.direction[d] = (c.start_offset[d] + c.end_offset[d]) / size;
}

/// a . W_ij b for the block of contacts i and j.
double block(const RowMatrix& w, int dimension, std::size_t i, std::size_t j, const double* a,
             const double* b) {
  if (dimension == 1) return a[0] * w(static_cast<int>(i), static_cast<int>(j)) * b[0];
  double sum = 0.0;
  for (int r = 0; r < dimension; ++r) {
    for (int s = 0; s < dimension; ++s) {
      sum += a[r] * w(static_cast<int>(i) * dimension + r, static_cast<int>(j) * dimension + s) * b[s];
    }
  }
  return sum;
}

/// free - W n F, one component.
double moved(double free, const std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w,
             int row) {
  double offset = free;
  for (std::size_t j = 0; j < contacts.size(); ++j) {
    for (int s = 0; s < dimension; ++s) {
      offset -= w(row, static_cast<int>(j) * dimension + s) * contacts[j].direction[s] * contacts[j].force;
    }
  }
  return offset;
}

}  // namespace

double contact_distance(StopShape shape, const double* offset, int dimension) {
  if (shape == StopShape::wall) return offset[0];
  return dimension == 1 ? std::abs(offset[0]) : std::sqrt(dot(offset, offset, 2));
}

double contact_heat(const ClosedContact& c, double step) {
  return mean_damping(c) * (c.end_penetration - c.prior_penetration) / step *
         (c.end_penetration - c.start_penetration);
}

void ContactSolver::reserve(int points, int dimension) {
  free_.resize(points * dimension);
  start_free_.resize(points * dimension);
  start_slope_.resize(points);
  update_.resize(points);
  slope_.resize(points);
  jacobian_.resize(points * points);
}

void ContactSolver::move(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    ClosedContact& c = contacts[i];
    for (int r = 0; r < dimension; ++r) {
      const int row = static_cast<int>(i) * dimension + r;
      c.end_offset[r] = moved(free_[row], contacts, dimension, w, row);
    }
    c.end_penetration = contact_distance(c.shape, c.end_offset, dimension) - c.gap;
  }
}

void ContactSolver::move_start(std::vector<ClosedContact>& contacts, int dimension,
                               const RowMatrix& w_static) {
  if (!w_static.size()) return;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    ClosedContact& c = contacts[i];
    for (int r = 0; r < dimension; ++r) {
      const int row = static_cast<int>(i) * dimension + r;
      c.start_offset[r] = moved(start_free_[row], contacts, dimension, w_static, row);
    }
    c.start_penetration = contact_distance(c.shape, c.start_offset, dimension) - c.gap;
  }
}

void ContactSolver::eliminate(int n) {
  // J = I + (positive diagonal)(positive semidefinite): leading minors are positive, no pivoting needed.
  double* a = jacobian_.data();
  for (int k = 0; k < n; ++k) {
    const double inverse = 1.0 / a[k * n + k];
    for (int i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] * inverse;
      for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
      update_[i] -= factor * update_[k];
    }
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) update_[i] -= a[i * n + j] * update_[j];
    update_[i] /= a[i * n + i];
  }
}

bool ContactSolver::solve(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w,
                          const RowMatrix& w_static, double step) {
  const std::size_t n = contacts.size();
  for (std::size_t i = 0; i < n; ++i) {
    ClosedContact& c = contacts[i];
    std::copy_n(c.end_offset, dimension, &free_[i * dimension]);
    std::copy_n(c.start_offset, dimension, &start_free_[i * dimension]);
    c.start_penetration = contact_distance(c.shape, c.start_offset, dimension) - c.gap;
    mean_direction(contacts[i], dimension);
  }
  constexpr int most_iterations = 30;
  double last_change = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    move(contacts, dimension, w);
    move_start(contacts, dimension, w_static);
    bool settled = iteration > 0;
    double change = 0.0;  // largest movement still asked for, over the gap
    for (std::size_t i = 0; i < n; ++i) {
      ClosedContact& c = contacts[i];
      const double before[2] = {c.direction[0], c.direction[1]};
      mean_direction(c, dimension);
      c.normal_flexibility = block(w, dimension, i, i, c.direction, c.direction);
      const ForceAndSlope law = mean_force(c, step);
      update_[i] = law.force - c.force;
      slope_[i] = law.slope;
      start_slope_[i] = law.start_slope;
      double turned = 0.0;
      for (int d = 0; d < dimension; ++d) turned = std::max(turned, std::abs(c.direction[d] - before[d]));
      // Settled when what is missing would move the point by no more than the rounding of its offset.
      const double missing =
          std::abs(update_[i]) / (1.0 + law.slope * c.normal_flexibility) + turned * std::abs(c.force);
      const double movement = missing * c.normal_flexibility;
      settled = settled && (movement <= 1e-16 * (c.gap + std::abs(c.end_penetration)) ||
                            missing <= 1e-14 * std::abs(c.force));
      change = std::max(change, movement / (c.gap + std::abs(c.end_penetration)));
    }
    // Newton that no longer gains stands on the rounding of the offsets, which are differences of far larger
    // motions.
    const bool stalled = change < 1e-9 && change > 0.25 * last_change;
    last_change = change;
    if (settled || stalled) return true;
    for (std::size_t i = 0; i < n; ++i) {
      double normal[2], start_normal[2];
      end_normal(contacts[i], dimension, normal);
      unit_normal(contacts[i], contacts[i].start_offset, dimension, start_normal);
      for (std::size_t j = 0; j < n; ++j) {
        double& entry = jacobian_[i * n + j];
        entry = (i == j ? 1.0 : 0.0) + slope_[i] * block(w, dimension, i, j, normal, contacts[j].direction);
        if (w_static.size()) {
          entry += start_slope_[i] * block(w_static, dimension, i, j, start_normal, contacts[j].direction);
        }
      }
    }
    eliminate(static_cast<int>(n));
    for (std::size_t i = 0; i < n; ++i) contacts[i].force += update_[i];
  }
  return false;
}

}  // namespace struna::fem
