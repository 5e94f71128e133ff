#include "fem/body_dynamics.hpp"

#include <fmt/format.h>

#include <cmath>

#include "fem/error.hpp"
#include "fem/static_shape.hpp"

namespace struna::fem {
namespace {

/// The Rayleigh alpha that acts: it belongs to viscous damping alone.
double acting_alpha(const Material& material) {
  return material.damping == Damping::viscous ? material.rayleigh.alpha : 0.0;
}

OutputRow support_force_row(const Model& model, const Eigen::VectorXd& shape, const Coordinates& coordinates,
                            const BodyDrive& drive, const std::vector<JoinedPair>& pairs, int body) {
  const double alpha = acting_alpha(model.body.material);
  const Eigen::VectorXd momentum = multiply(model.mass, shape);
  const double carried_mass = momentum.dot(coordinates.carried);
  OutputRow row;
  row.on_acceleration = coordinates.basis.transpose() * momentum;
  row.on_velocity = alpha * row.on_acceleration;
  row.on_displacement = Eigen::VectorXd::Zero(row.on_acceleration.size());
  row.on_motion = {0.0, alpha * carried_mass, carried_mass};
  if (drive.force.size() > 0) row.on_motion[0] = -shape.dot(drive.force);
  row.static_stiffness = multiply(model.stiffness, shape).col(0).dot(coordinates.carried);
  row.constant = -shape.dot(gravity_load(model, drive.gravity));
  row.on_contact = Eigen::MatrixX2d::Zero(static_cast<long>(pairs.size()), 2);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto at = static_cast<long>(p);
    if (pairs[p].inside_body == body)
      row.on_contact.row(at) -= shape.transpose() * pairs[p].pair.inside_weights;
    if (pairs[p].outside_body == body)
      row.on_contact.row(at) += shape.transpose() * pairs[p].pair.outside_weights;
  }
  return row;
}

OutputRow point_motion_row(const Eigen::VectorXd& weights, MotionQuantity quantity,
                           const Coordinates& coordinates, std::size_t contact_points) {
  const Eigen::VectorXd active = coordinates.basis.transpose() * weights;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(active.size());
  OutputRow row{none, none, none, Eigen::Vector3d::Zero(), 0.0, {}, 0.0};
  const int order = quantity == MotionQuantity::displacement ? 0
                    : quantity == MotionQuantity::velocity   ? 1
                                                             : 2;
  (order == 0 ? row.on_displacement : order == 1 ? row.on_velocity : row.on_acceleration) = active;
  row.on_motion[order] = weights.dot(coordinates.carried);
  row.on_contact = Eigen::MatrixX2d::Zero(static_cast<long>(contact_points), 2);
  return row;
}

/// Gravity has no static rest to start from where a body is free to follow it.
void refuse_falling(const Model& model, const Eigenmodes& modes, const Eigen::VectorXd& load) {
  constexpr double rounding = 1e-8;
  for (long m = 0; m < load.size(); ++m) {
    if (!is_rigid(model.body, modes.eigenvalue[m]) ||
        std::abs(load[m]) <= rounding * load.cwiseAbs().maxCoeff()) {
      continue;
    }
    throw Error(fmt::format(
        "simulate: gravity makes body '{}' fall or swing, because its supports leave it free to; a run with "
        "gravity starts from a static rest, and there is none: clamp an end, or leave gravity out",
        model.body.name));
  }
}

}  // namespace

Eigen::VectorXd gravity_load(const Model& model, const Eigen::Vector3d& gravity) {
  Eigen::VectorXd translation = Eigen::VectorXd::Zero(model.dof_count());
  for (long dof = 0; dof < model.dof_count(); dof += 6) translation.segment<3>(dof) = gravity;
  return multiply(model.mass, translation);
}

BodyDrive body_drive(const Scene& scene, const Model& model) {
  BodyDrive drive;
  if (scene.simulation) drive.gravity = scene.simulation->gravity;
  if (!scene.drive) return drive;
  drive.direction = scene.drive->direction;
  if (const auto* point = std::get_if<BodyPoint>(&scene.drive->at)) {
    if (point->body == model.body.name)
      drive.force = point_functional(model, point->fraction, drive.direction);
    return drive;
  }
  std::vector<Support> supports = scene.drive->also;
  supports.push_back(std::get<Support>(scene.drive->at));
  for (const End end : {End::start, End::end}) {
    for (const auto& support : supports) {
      if (support.body == model.body.name && support.end == end) {
        drive.moved.push_back(end);
        break;
      }
    }
  }
  return drive;
}

Coordinates modal_coordinates(const Model& model, const Eigenmodes& complete_modes, const BodyDrive& drive) {
  return {complete_modes.shape, static_shape(model, complete_modes, drive.moved, drive.direction)};
}

Coordinates nodal_coordinates(const Model& model, const BodyDrive& drive) {
  Coordinates coordinates{Eigen::MatrixXd::Zero(model.dof_count(), static_cast<long>(model.free_dof.size())),
                          Eigen::VectorXd::Zero(model.dof_count())};
  for (std::size_t i = 0; i < model.free_dof.size(); ++i)
    coordinates.basis(model.free_dof[i], static_cast<long>(i)) = 1.0;
  for (const End end : drive.moved) coordinates.carried.segment<3>(first_dof(model, end)) = drive.direction;
  return coordinates;
}

ModalBody modal_body(const Model& model, const Eigenmodes& complete_modes, const Coordinates& coordinates,
                     const BodyDrive& drive, double band_hi_hz) {
  const Material& material = model.body.material;
  ModalBody body;
  body.poles = pole_system(model, complete_modes, material.damping, band_hi_hz);
  body.load = Eigen::MatrixX3d::Zero(coordinates.basis.cols(), 3);
  const Eigen::VectorXd participation =
      coordinates.basis.transpose() * multiply(model.mass, coordinates.carried);
  body.load.col(1) = -acting_alpha(material) * participation;
  body.load.col(2) = -participation;
  if (drive.force.size() > 0) body.load.col(0) = coordinates.basis.transpose() * drive.force;
  if (!drive.gravity.isZero(0.0)) {
    body.constant_load = coordinates.basis.transpose() * gravity_load(model, drive.gravity);
    refuse_falling(model, complete_modes, body.constant_load);
  }
  return body;
}

ContactPoint contact_point(const ContactPair& pair, const Contact& contact, const Coordinates& inside,
                           const Coordinates& outside, int inside_body, int outside_body) {
  ContactPoint point;
  point.law = contact_force_law(contact);
  point.gap = contact.gap;
  point.inside_body = inside_body;
  point.outside_body = outside_body;
  point.rest_offset = pair.rest_offset;
  point.motion =
      pair.inside_weights.transpose() * inside.carried - pair.outside_weights.transpose() * outside.carried;
  point.inside = inside.basis.transpose() * pair.inside_weights;
  point.outside = outside.basis.transpose() * pair.outside_weights;
  return point;
}

std::vector<OutputRow> output_rows(const SceneMeasurement& measurement, const Model& model,
                                   const Eigenmodes& complete_modes, const Coordinates& coordinates,
                                   const BodyDrive& drive, const std::vector<JoinedPair>& pairs, int body) {
  std::vector<OutputRow> rows;
  for (const auto& direction : measurement.directions) {
    if (const auto* support = std::get_if<Support>(&measurement.at)) {
      const auto shape = static_shape(model, complete_modes, {support->end}, direction);
      rows.push_back(support_force_row(model, shape, coordinates, drive, pairs, body));
    } else {
      const auto weights = point_functional(model, std::get<BodyPoint>(measurement.at).fraction, direction);
      rows.push_back(point_motion_row(weights, measurement.quantity, coordinates, pairs.size()));
    }
  }
  return rows;
}

ModulusMemory::ModulusMemory(const MaxwellLaw& law, const MotionSample& start)
    : law_(law),
      internal_(Eigen::VectorXd::Constant(law.strength.size(), start.displacement)),
      last_(start.displacement),
      value_(evaluate(start)) {}

double ModulusMemory::evaluate(const MotionSample& u) const {
  const double memory = law_.strength.dot((u.displacement - internal_.array()).matrix());
  return law_.relaxed * u.displacement + memory + law_.viscosity * u.velocity;
}

double ModulusMemory::advance(double interval, const MotionSample& u) {
  // Exact for u linear in time: x(h) = u1 - tau s + (x0 - u0 + tau s) e^{-h/tau}, s = (u1 - u0)/h.
  const double slope = (u.displacement - last_) / interval;
  for (long j = 0; j < internal_.size(); ++j) {
    const double lag = law_.relaxation_time[j] * slope;
    const double decay = std::exp(-interval / law_.relaxation_time[j]);
    internal_[j] = u.displacement - lag + (internal_[j] - last_ + lag) * decay;
  }
  last_ = u.displacement;
  value_ = evaluate(u);
  return value_;
}

}  // namespace struna::fem
