#include "fem/static_shape.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

bool held(const Body& body, End end) {
  return (end == End::start ? body.start : body.end) != EndCondition::free;
}

}  // namespace

Eigen::VectorXd static_shape(const Model& model, const Eigenmodes& modes, const std::vector<End>& ends,
                             const Eigen::Vector3d& direction) {
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(model.dof_count());
  for (const End end : ends) {
    if (!held(model.body, end)) {
      throw Error(fmt::format("static_shape: only a support can be moved, but the {} of body '{}' is free",
                              end == End::start ? "start" : "end", model.body.name));
    }
  }
  const auto moves = [&](End end) { return std::find(ends.begin(), ends.end(), end) != ends.end(); };
  // Start from a translation that is linear between the supports: nearly stress-free, so that little cancels.
  const auto level = [&](End end, End other) {
    if (moves(end)) return 1.0;
    return !held(model.body, end) && moves(other) ? 1.0 : 0.0;
  };
  const double at_start = level(End::start, End::end);
  const double at_end = level(End::end, End::start);
  const double length = model.arc_length.back();
  for (std::size_t node = 0; node < model.arc_length.size(); ++node) {
    const double x = model.arc_length[node] / length;
    shape.segment<3>(model.node_dof(static_cast<int>(node))) =
        ((1.0 - x) * at_start + x * at_end) * direction;
  }
  if (model.start_bases > 0) shape.segment<3>(first_dof(model, End::start)) = at_start * direction;
  if (model.end_bases > 0) shape.segment<3>(first_dof(model, End::end)) = at_end * direction;
  const Eigen::VectorXd load = -(modes.shape.transpose() * multiply(model.stiffness, shape)).col(0);
  for (long r = rigid_modes(model.body, modes.eigenvalue); r < modes.eigenvalue.size(); ++r) {
    shape += load[r] / modes.eigenvalue[r] * modes.shape.col(r);
  }
  return shape;
}

}  // namespace struna::fem
