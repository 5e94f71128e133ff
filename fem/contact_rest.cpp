#include "fem/contact_rest.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace struna::fem {
namespace {

using Eigen::VectorXd;

/// The springs at given offsets: energy, force of each component and its slope.
struct Springs {
  double energy = 0.0;
  VectorXd force;
  std::vector<Eigen::Matrix2d> slope;  ///< d force/d offset per point
};

Springs springs_at(const std::vector<ClosedContact>& contacts, int d, const VectorXd& offset) {
  Springs springs{0.0, VectorXd::Zero(offset.size()), {}};
  springs.slope.assign(contacts.size(), Eigen::Matrix2d::Zero());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ClosedContact& c = contacts[i];
    const long at = static_cast<long>(i) * d;
    const double distance = contact_distance(c.shape, &offset[at], d);
    const double penetration = distance - c.gap;
    if (!(penetration > 0.0)) continue;
    Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
    double turning = 0.0;
    if (c.shape == StopShape::bore) {
      for (int s = 0; s < d; ++s) normal[s] = offset[at + s] / distance;
      turning = penetration / distance;
    }
    const double k = c.law->stiffness;
    springs.energy += spring_energy(*c.law, penetration);
    for (int s = 0; s < d; ++s) springs.force[at + s] = k * penetration * normal[s];
    springs.slope[i] = k * (1.0 - turning) * normal * normal.transpose();
    springs.slope[i].diagonal().array() += k * turning;
  }
  return springs;
}

/// 1 + (slope of the springs) W.
Eigen::MatrixXd newton_matrix(const Springs& springs, int d, const RowMatrix& w) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(w.rows(), w.cols());
  for (std::size_t i = 0; i < springs.slope.size(); ++i) {
    const long at = static_cast<long>(i) * d;
    matrix.middleRows(at, d) += springs.slope[i].topLeftCorner(d, d) * w.middleRows(at, d);
  }
  return matrix;
}

void put(const VectorXd& offset, const VectorXd& force, int d, std::vector<ClosedContact>& contacts) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    ClosedContact& c = contacts[i];
    const long at = static_cast<long>(i) * d;
    c.end_penetration = contact_distance(c.shape, &offset[at], d) - c.gap;
    // Along h to rounding; the force's own direction, since the offsets follow from this very force.
    c.force = c.shape == StopShape::wall ? force[at] : force.segment(at, d).norm();
    for (int s = 0; s < d; ++s) {
      c.end_offset[s] = offset[at + s];
      c.direction[s] = c.force != 0.0 ? force[at + s] / c.force : s == 0 ? 1.0 : 0.0;
    }
  }
}

}  // namespace

bool rest_in_contact(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w) {
  const int d = dimension;
  if (contacts.empty()) return true;
  VectorXd free(static_cast<long>(contacts.size()) * d);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    for (int s = 0; s < d; ++s) free[static_cast<long>(i) * d + s] = contacts[i].end_offset[s];
  }
  if (!free.allFinite() || !w.allFinite()) return false;
  VectorXd force = VectorXd::Zero(free.size());
  VectorXd bent = force;  // W force
  Springs springs = springs_at(contacts, d, free);
  constexpr int most_iterations = 200;
  double last_change = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const VectorXd update = newton_matrix(springs, d, w).partialPivLu().solve(springs.force - force);
    const VectorXd bend = w * update;
    const double energy = 0.5 * force.dot(bent) + springs.energy;
    const double descent = bend.dot(force - springs.force);  // of the energy along the update, <= 0
    double share = 1.0;
    for (int halvings = 0; halvings < 40; ++halvings, share *= 0.5) {
      const VectorXd tried = force + share * update;
      const VectorXd tried_bent = bent + share * bend;
      Springs next = springs_at(contacts, d, free - tried_bent);
      // The energy is known to its rounding only; close to the minimum that decides nothing.
      const double rounding = 1e-13 * (energy + std::abs(tried.dot(tried_bent)));
      if (0.5 * tried.dot(tried_bent) + next.energy <= energy + 1e-4 * share * descent + rounding) {
        springs = std::move(next);
        break;
      }
    }
    force += share * update;
    bent = w * force;
    springs = springs_at(contacts, d, free - bent);
    const double largest = force.cwiseAbs().maxCoeff();
    const double change = update.cwiseAbs().maxCoeff();
    // Forces are differences of far larger motions times k: where Newton no longer gains, that is their
    // rounding.
    const bool stalled = change <= 1e-6 * largest && change > 0.25 * last_change;
    if (change <= 1e-13 * largest || stalled) {
      put(free - bent, force, d, contacts);
      return true;
    }
    last_change = change;
  }
  return false;
}

}  // namespace struna::fem
