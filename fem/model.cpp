#include "fem/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/beam_element.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

constexpr int dof_per_node = 6;
constexpr int band_rows = 2 * dof_per_node;

void add_element(BandMatrix& matrix, int dof, const Matrix12& part) {
  for (int j = 0; j < band_rows; ++j) {
    matrix.lower.col(dof + j).head(band_rows - j) += part.col(j).tail(band_rows - j);
  }
}

/// Adds the lower halves of up to four elements, the first one's first dof being `dof`.
void add_elements(BandMatrix& matrix, int dof, int count, const Matrix12L& part) {
  for (int lane = 0; lane < Lane::count && lane < count; ++lane) {
    for (int j = 0; j < band_rows; ++j) {
      double* const column = matrix.lower.col(dof + dof_per_node * lane + j).data();
      for (int i = j; i < band_rows; ++i) column[i - j] += part(i, j)[lane];
    }
  }
}

/// Whether the end's own node is held, and not a spring's.
bool holds(EndCondition condition, const ElasticSupport& support, int direction) {
  if (condition == EndCondition::free) return false;
  if (direction < 3) return !support.gives_translation();
  return condition == EndCondition::clamped && !support.gives_rotation();
}

/// Springs of one end, over E0, and its mass. `base`: first dof of the base, or of the node where there is
/// none.
void add_support(Model& model, const ElasticSupport& support, int node, int base) {
  const auto over_modulus = [&](double stiffness) {
    return stiffness / model.body.material.youngs_modulus.at(support_reference_hz);
  };
  for (int direction = 0; direction < 3; ++direction) {
    const int dof = node + direction;
    model.mass.lower(0, dof) += support.mass;
    if (support.gives_rotation()) model.stiffness.lower(0, dof + 3) += over_modulus(support.rotation);
    if (!support.gives_translation()) continue;
    const double spring = over_modulus(support.translation);
    model.stiffness.lower(0, dof) += spring;
    model.stiffness.lower(0, base + direction) += spring;
    model.stiffness.lower(dof_per_node, std::min(node, base) + direction) -= spring;
  }
}

void split_dof(Model& model) {
  const int last_node = static_cast<int>(model.arc_length.size()) - 1;
  const Body& body = model.body;
  for (int dof = 0; dof < model.dof_count(); ++dof) {
    const int node = dof / dof_per_node - model.start_bases;
    const int direction = dof % dof_per_node;
    const bool held = node < 0 || node > last_node ||
                      (node == 0 && holds(body.start, body.start_support, direction)) ||
                      (node == last_node && holds(body.end, body.end_support, direction));
    (held ? model.held_dof : model.free_dof).push_back(dof);
  }
}

}  // namespace

Model assemble(const Body& body, int elements) {
  validate(body);
  const int count = elements == 0 ? body.elements : elements;
  if (count < 1) {
    throw Error(fmt::format("assemble: body '{}' needs at least 1 element, got {}", body.name, count));
  }
  Model model{body, {}, {}, {}, {}, {}, {}};
  model.start_bases = body.start_support.gives_translation() ? 1 : 0;
  model.end_bases = body.end_support.gives_translation() ? 1 : 0;
  const double length = body.centreline.length();
  for (int i = 0; i <= count; ++i) {
    model.arc_length.push_back(length * i / count);
    model.position.push_back(body.centreline.at(model.arc_length.back()).position);
  }
  model.stiffness.lower.setZero(band_rows, model.dof_count());
  model.mass.lower.setZero(band_rows, model.dof_count());
  if (body.centreline.is_straight()) {
    const ElementMatrices part = straight_beam_element(body, length / count, body.centreline.at(0.0).tangent);
    for (int i = 0; i < count; ++i) {
      add_element(model.stiffness, model.node_dof(i), part.stiffness);
      add_element(model.mass, model.node_dof(i), part.mass);
    }
  } else {
    for (int i = 0; i < count; i += Lane::count) {
      const LaneElementMatrices part = beam_elements(body, model.arc_length, model.position, i);
      add_elements(model.stiffness, model.node_dof(i), count - i, part.stiffness);
      add_elements(model.mass, model.node_dof(i), count - i, part.mass);
    }
  }
  add_support(model, body.start_support, model.node_dof(0), first_dof(model, End::start));
  add_support(model, body.end_support, model.node_dof(count), first_dof(model, End::end));
  split_dof(model);
  return model;
}

int first_dof(const Model& model, End end) {
  return end == End::start ? 0 : model.dof_count() - dof_per_node;
}

Eigen::VectorXd point_functional(const Model& model, double fraction, const Eigen::Vector3d& direction) {
  if (!(fraction >= 0.0 && fraction <= 1.0)) {
    throw Error(
        fmt::format("point_functional: fraction of the arc length must lie in [0, 1], got {:g}", fraction));
  }
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(model.dof_count());
  const int elements = static_cast<int>(model.arc_length.size()) - 1;
  const double place = fraction * elements;
  const double node = std::round(place);
  if (std::abs(place - node) < 1e-9) {
    weight.segment<3>(model.node_dof(static_cast<int>(node))) = direction;
    return weight;
  }
  const int element = static_cast<int>(place);
  weight.segment<band_rows>(model.node_dof(element)) =
      beam_displacement(model.body, model.arc_length[element], model.arc_length[element + 1],
                        fraction * model.arc_length.back())
          .transpose() *
      direction;
  return weight;
}

}  // namespace struna::fem
