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

void add_element(BandMatrix& matrix, int element, const Matrix12& part) {
  for (int j = 0; j < band_rows; ++j) {
    matrix.lower.col(dof_per_node * element + j).head(band_rows - j) += part.col(j).tail(band_rows - j);
  }
}

/// Adds the lower halves of four elements, as far as there are so many.
void add_elements(BandMatrix& matrix, int first, int count, const Matrix12L& part) {
  for (int lane = 0; lane < Lane::count && first + lane < count; ++lane) {
    for (int j = 0; j < band_rows; ++j) {
      double* const column = matrix.lower.col(dof_per_node * (first + lane) + j).data();
      for (int i = j; i < band_rows; ++i) column[i - j] += part(i, j)[lane];
    }
  }
}

bool holds(EndCondition condition, int direction) {
  if (condition == EndCondition::clamped) return true;
  return condition == EndCondition::pinned && direction < 3;
}

void split_dof(Model& model) {
  const int last_node = static_cast<int>(model.arc_length.size()) - 1;
  for (int dof = 0; dof < model.dof_count(); ++dof) {
    const int node = dof / dof_per_node;
    const int direction = dof % dof_per_node;
    const bool held = (node == 0 && holds(model.body.start, direction)) ||
                      (node == last_node && holds(model.body.end, direction));
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
      add_element(model.stiffness, i, part.stiffness);
      add_element(model.mass, i, part.mass);
    }
  } else {
    for (int i = 0; i < count; i += Lane::count) {
      const LaneElementMatrices part = beam_elements(body, model.arc_length, model.position, i);
      add_elements(model.stiffness, i, count, part.stiffness);
      add_elements(model.mass, i, count, part.mass);
    }
  }
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
    weight.segment<3>(dof_per_node * static_cast<int>(node)) = direction;
    return weight;
  }
  const int element = static_cast<int>(place);
  weight.segment<band_rows>(dof_per_node * element) =
      beam_displacement(model.body, model.arc_length[element], model.arc_length[element + 1],
                        fraction * model.arc_length.back())
          .transpose() *
      direction;
  return weight;
}

}  // namespace struna::fem
