#include "fem/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace struna::fem {
namespace {

/// A force and its derivative with respect to the penetration at the end of the step.
struct ForceAndSlope {
  double force = 0.0;
  double slope = 0.0;
};

ForceAndSlope mean_force(const ClosedContact& c, double step) {
  const double mean = 0.5 * (c.start_penetration + c.end_penetration);
  const double rate = (c.end_penetration - c.start_penetration) / step;
  const double k = c.law->stiffness;
  if (c.phase == ContactPhase::unloading) return {k * mean, 0.5 * k};
  if (c.law->kind == ContactLaw::hunt_crossley) {
    const double d = c.law->damping / c.law->damping_length;
    return {mean * (k + d * rate), 0.5 * (k + d * rate) + mean * d / step};
  }
  return {k * mean + c.law->damping * rate, 0.5 * k + c.law->damping / step};
}

double dot(const double* a, const double* b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Unit direction of the penetration at the end of the step.
void end_normal(const ClosedContact& c, int dimension, double* normal) {
  if (c.shape == StopShape::wall) {
    normal[0] = 1.0;
    normal[1] = 0.0;
    return;
  }
  const double size = contact_distance(c.shape, c.end_offset, dimension);
  for (int d = 0; d < dimension; ++d) normal[d] = size > 0.0 ? c.end_offset[d] / size : (d == 0 ? 1.0 : 0.0);
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

}  // namespace

double contact_distance(StopShape shape, const double* offset, int dimension) {
  if (shape == StopShape::wall) return offset[0];
  return dimension == 1 ? std::abs(offset[0]) : std::sqrt(dot(offset, offset, 2));
}

double contact_heat(const ClosedContact& c, double step) {
  if (c.phase == ContactPhase::unloading) return 0.0;
  const double change = c.end_penetration - c.start_penetration;
  const double heat = c.law->damping * change * change / step;
  if (c.law->kind != ContactLaw::hunt_crossley) return heat;
  return heat * 0.5 * (c.start_penetration + c.end_penetration) / c.law->damping_length;
}

void ContactSolver::reserve(int points, int dimension) {
  free_.resize(points * dimension);
  update_.resize(points);
  slope_.resize(points);
  jacobian_.resize(points * points);
}

void ContactSolver::move(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w) {
  const std::size_t n = contacts.size();
  for (std::size_t i = 0; i < n; ++i) {
    ClosedContact& c = contacts[i];
    for (int r = 0; r < dimension; ++r) {
      const int row = static_cast<int>(i) * dimension + r;
      double offset = free_[row];
      for (std::size_t j = 0; j < n; ++j) {
        for (int s = 0; s < dimension; ++s) {
          offset -=
              w(row, static_cast<int>(j) * dimension + s) * contacts[j].direction[s] * contacts[j].force;
        }
      }
      c.end_offset[r] = offset;
    }
    c.end_penetration = contact_distance(c.shape, c.end_offset, dimension) - c.gap;
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
                          double step) {
  const std::size_t n = contacts.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::copy_n(contacts[i].end_offset, dimension, &free_[i * dimension]);
    mean_direction(contacts[i], dimension);
  }
  constexpr int most_iterations = 30;
  double last_change = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    move(contacts, dimension, w);
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
      double turned = 0.0;
      for (int d = 0; d < dimension; ++d) turned = std::max(turned, std::abs(c.direction[d] - before[d]));
      // Settled when what is missing would move the point by no more than the rounding of its offset.
      const double missing =
          std::abs(update_[i]) / (1.0 + law.slope * c.normal_flexibility) + turned * std::abs(c.force);
      const double moved = missing * c.normal_flexibility;
      settled = settled && (moved <= 1e-16 * (c.gap + std::abs(c.end_penetration)) ||
                            missing <= 1e-14 * std::abs(c.force));
      change = std::max(change, moved / (c.gap + std::abs(c.end_penetration)));
    }
    // Newton that no longer gains stands on the rounding of the offsets, which are differences of far larger
    // motions.
    const bool stalled = change < 1e-9 && change > 0.25 * last_change;
    last_change = change;
    if (settled || stalled) return true;
    for (std::size_t i = 0; i < n; ++i) {
      double normal[2];
      end_normal(contacts[i], dimension, normal);
      for (std::size_t j = 0; j < n; ++j) {
        jacobian_[i * n + j] =
            (i == j ? 1.0 : 0.0) + slope_[i] * block(w, dimension, i, j, normal, contacts[j].direction);
      }
    }
    eliminate(static_cast<int>(n));
    for (std::size_t i = 0; i < n; ++i) contacts[i].force += update_[i];
  }
  return false;
}

bool ContactSolver::settle(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w) {
  const std::size_t n = contacts.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::copy_n(contacts[i].end_offset, dimension, &free_[i * dimension]);
    contacts[i].force = 0.0;
    end_normal(contacts[i], dimension, contacts[i].direction);
  }
  constexpr int most_iterations = 500;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    move(contacts, dimension, w);
    double largest = 0.0;
    double change = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      ClosedContact& c = contacts[i];
      end_normal(c, dimension, c.direction);
      const bool closed = c.end_penetration > 0.0;
      const double stiffness = closed ? c.law->stiffness : 0.0;
      update_[i] = stiffness * c.end_penetration - c.force;
      for (std::size_t j = 0; j < n; ++j) {
        jacobian_[i * n + j] =
            (i == j ? 1.0 : 0.0) + stiffness * block(w, dimension, i, j, c.direction, contacts[j].direction);
      }
    }
    eliminate(static_cast<int>(n));
    // Full Newton steps first; halved ones afterwards, against cycling between sets of closed points.
    const double share = iteration < 20 ? 1.0 : 0.5;
    for (std::size_t i = 0; i < n; ++i) {
      contacts[i].force += share * update_[i];
      largest = std::max(largest, std::abs(contacts[i].force));
      change = std::max(change, std::abs(update_[i]));
    }
    // Forces are differences of far larger motions times k: their rounding is above that of the forces
    // themselves.
    if (change > 1e-11 * largest) continue;
    move(contacts, dimension, w);
    return true;
  }
  return false;
}

}  // namespace struna::fem
