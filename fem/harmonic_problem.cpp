#include "fem/harmonic_problem.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

void check_direction(const Vector3d& direction, const char* what) {
  if (!(std::abs(direction.norm() - 1.0) < 1e-9)) {
    throw Error(fmt::format(
        "harmonic_response: the direction of the {} must be a unit vector, got ({:g}, {:g}, {:g})", what,
        direction.x(), direction.y(), direction.z()));
  }
}

EndCondition condition_at(const Body& body, End end) {
  return end == End::start ? body.start : body.end;
}

/// Adds a translation of a support along `direction` to a vector over all dof.
void add_support(const Model& model, End end, const Vector3d& direction, const char* what, VectorXd& vector) {
  if (condition_at(model.body, end) == EndCondition::free) {
    throw Error(fmt::format("harmonic_response: the {} must be a support, but the {} of body '{}' is free",
                            what, end == End::start ? "start" : "end", model.body.name));
  }
  vector.segment<3>(first_dof(model, end)) = direction;
}

Terminal at_point(VectorXd vector) {
  return {std::move(vector), false, {}, {}};
}

Terminal at_supports(const Model& model, VectorXd vector) {
  VectorXd k = multiply_sparse(model.stiffness, vector);
  VectorXd m = multiply_sparse(model.mass, vector);
  return {std::move(vector), true, std::move(k), std::move(m)};
}

HarmonicProblem::Part on_free_dof(const Terminal& terminal, const Model& model) {
  if (!terminal.at_support) return {false, {}, {}, terminal.vector(model.free_dof)};
  return {true, terminal.k(model.free_dof), terminal.m(model.free_dof), {}};
}

HarmonicProblem::Direct direct_part(const Terminal& in, const Terminal& out) {
  if (in.at_support && out.at_support) return {out.k.dot(in.vector), out.m.dot(in.vector), 0.0};
  if (in.at_support) return {0.0, 0.0, out.vector.dot(in.vector)};
  // The part of a load that goes straight into the support.
  if (out.at_support) return {0.0, 0.0, -out.vector.dot(in.vector)};
  return {};
}

}  // namespace

DynamicScales dynamic_scales(const Material& material, Damping damping, double f_hz) {
  using Complex = std::complex<double>;
  const double omega = 2.0 * std::numbers::pi * f_hz;
  const double modulus = material.youngs_modulus.at(f_hz);
  if (damping == Damping::structural)
    return {modulus * Complex(1.0, material.loss_factor.at(f_hz)), -omega * omega};
  return {modulus * Complex(1.0, omega * material.rayleigh.beta),
          Complex(-omega * omega, omega * material.rayleigh.alpha)};
}

Terminal drive_terminal(const Model& model, const Drive& drive) {
  if (const auto* force = std::get_if<PointForce>(&drive)) {
    check_direction(force->direction, "drive");
    return at_point(point_functional(model, force->fraction, force->direction));
  }
  const auto& motion = std::get<SupportMotion>(drive);
  check_direction(motion.direction, "drive");
  if (motion.ends.empty())
    throw Error("harmonic_response: the drive must name at least one support, got none");
  VectorXd vector = VectorXd::Zero(model.dof_count());
  for (const End end : motion.ends) add_support(model, end, motion.direction, "drive", vector);
  return at_supports(model, std::move(vector));
}

std::vector<Terminal> output_terminals(const Model& model, const Measurement& measurement) {
  if (measurement.directions.empty())
    throw Error("harmonic_response: at least one measured direction, got none");
  std::vector<Terminal> all;
  for (const Vector3d& direction : measurement.directions) {
    check_direction(direction, "measurement");
    if (const auto* support = std::get_if<SupportForce>(&measurement.what)) {
      VectorXd vector = VectorXd::Zero(model.dof_count());
      add_support(model, support->end, direction, "measured support", vector);
      all.push_back(at_supports(model, std::move(vector)));
    } else {
      const double fraction = std::get<PointDisplacement>(measurement.what).fraction;
      all.push_back(at_point(point_functional(model, fraction, direction)));
    }
  }
  return all;
}

HarmonicProblem::HarmonicProblem(const Model& model, const Drive& driven, const Measurement& measurement)
    : stiffness(submatrix(model.stiffness, model.free_dof)), mass(submatrix(model.mass, model.free_dof)) {
  const Terminal in = drive_terminal(model, driven);
  drive = on_free_dof(in, model);
  for (const Terminal& out : output_terminals(model, measurement)) {
    outputs.push_back(on_free_dof(out, model));
    direct.push_back(direct_part(in, out));
  }
}

}  // namespace struna::fem
