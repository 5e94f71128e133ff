#include "fem/plane_modes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace struna::fem {
namespace {

/// Columns: across the axis as near to `direction` as can be, the third, the axis.
Eigen::Matrix3d frame(const Eigen::Vector3d& axis, const Eigen::Vector3d& direction) {
  Eigen::Vector3d across = direction - direction.dot(axis) * axis;
  if (across.norm() < 1e-6) across = axis.unitOrthogonal();
  across.normalize();
  Eigen::Matrix3d columns;
  columns << across, axis.cross(across), axis;
  return columns;
}

/// The matrix in the frame's axes; what is only rounding of a coupling becomes zero.
BandMatrix rotated(const BandMatrix& a, const Eigen::Matrix3d& axes) {
  const int half = a.half_bandwidth();
  Eigen::MatrixXd dense = a.dense();
  for (int i = 0; i < a.size(); i += 3)
    dense.middleRows<3>(i) = (axes.transpose() * dense.middleRows<3>(i)).eval();
  for (int j = 0; j < a.size(); j += 3) dense.middleCols<3>(j) = (dense.middleCols<3>(j) * axes).eval();
  BandMatrix result{Eigen::MatrixXd::Zero(a.lower.rows(), a.lower.cols())};
  for (int j = 0; j < a.size(); ++j) {
    for (int k = 0; k <= half && j + k < a.size(); ++k) {
      const double scale = std::sqrt(std::abs(dense(j, j) * dense(j + k, j + k)));
      if (std::abs(dense(j + k, j)) > 1e-12 * scale) result.lower(k, j) = dense(j + k, j);
    }
  }
  return result;
}

/// Groups of the free dof that neither matrix couples.
std::vector<std::vector<int>> uncoupled_groups(const Model& model) {
  std::vector<int> group(static_cast<std::size_t>(model.dof_count()));
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](int i) {
    while (group[static_cast<std::size_t>(i)] != i) i = group[static_cast<std::size_t>(i)];
    return i;
  };
  std::vector<bool> free(group.size(), false);
  for (const int dof : model.free_dof) free[static_cast<std::size_t>(dof)] = true;
  for (int j = 0; j < model.dof_count(); ++j) {
    for (int k = 1; k <= model.stiffness.half_bandwidth() && j + k < model.dof_count(); ++k) {
      const bool coupled = model.stiffness.lower(k, j) != 0.0 || model.mass.lower(k, j) != 0.0;
      if (coupled && free[static_cast<std::size_t>(j)] && free[static_cast<std::size_t>(j + k)]) {
        group[static_cast<std::size_t>(root(j + k))] = root(j);
      }
    }
  }
  std::vector<std::vector<int>> groups(group.size());
  for (const int dof : model.free_dof) groups[static_cast<std::size_t>(root(dof))].push_back(dof);
  std::erase_if(groups, [](const auto& members) { return members.empty(); });
  return groups;
}

}  // namespace

Eigenmodes solve_plane_modes(const Model& model, const Eigen::Vector3d& direction, int count) {
  if (!model.body.centreline.is_straight()) return solve_eigenmodes(model, count);
  const Eigen::Matrix3d axes = frame(model.body.centreline.at(0.0).tangent, direction);
  Model turned = model;
  turned.stiffness = rotated(model.stiffness, axes);
  turned.mass = rotated(model.mass, axes);

  const auto free = static_cast<long>(model.free_dof.size());
  Eigenmodes found{Eigen::VectorXd(free), Eigen::MatrixXd::Zero(model.dof_count(), free)};
  long next = 0;
  for (const auto& group : uncoupled_groups(turned)) {
    turned.free_dof = group;
    const Eigenmodes part = solve_eigenmodes(turned, count);
    const long size = part.eigenvalue.size();
    found.eigenvalue.segment(next, size) = part.eigenvalue;
    found.shape.middleCols(next, size) = part.shape;
    next += size;
  }
  for (int i = 0; i < model.dof_count(); i += 3) {
    found.shape.middleRows<3>(i) = (axes * found.shape.middleRows<3>(i)).eval();
  }
  std::vector<long> order(static_cast<std::size_t>(next));
  std::iota(order.begin(), order.end(), 0L);
  std::stable_sort(order.begin(), order.end(),
                   [&](long a, long b) { return found.eigenvalue[a] < found.eigenvalue[b]; });
  if (count > 0) order.resize(static_cast<std::size_t>(std::min<long>(count, next)));
  return {found.eigenvalue(order), found.shape(Eigen::all, order)};
}

}  // namespace struna::fem
