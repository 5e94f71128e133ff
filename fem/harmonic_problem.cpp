#include "fem/harmonic_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// Below this share of the largest that a definite matrix allows, an entry is rounding: of directions that
/// should be zero, such as cos(90 deg).
constexpr double rounding = 1e-13;

bool joins(const BandMatrix& a, int i, int j) {
  const double entry = a.at(i, j);
  return entry * entry > rounding * rounding * a.at(i, i) * a.at(j, j);
}

/// Whether a unit motion d of supports, with the row A d, loads dof i.
bool loads(const BandMatrix& a, const VectorXd& row, const VectorXd& motion, int i) {
  return row(i) * row(i) > rounding * rounding * a.at(i, i) * motion.dot(row);
}

bool is_driven(const Model& model, const Terminal& drive, int i) {
  if (!drive.at_support) return std::abs(drive.vector(i)) > rounding * drive.vector.cwiseAbs().maxCoeff();
  return loads(model.stiffness, drive.k, drive.vector, i) || loads(model.mass, drive.m, drive.vector, i);
}

/// The free dof that K1 and M join to the drive, over any number of others.
std::vector<int> reached_dof(const Model& model, const Terminal& drive) {
  enum State : char { held, at_rest, reached };
  std::vector<State> state(static_cast<std::size_t>(model.dof_count()), held);
  std::vector<int> next;
  const auto reach = [&](int i) {
    state[static_cast<std::size_t>(i)] = reached;
    next.push_back(i);
  };
  for (const int i : model.free_dof) {
    state[static_cast<std::size_t>(i)] = at_rest;
    if (is_driven(model, drive, i)) reach(i);
  }
  while (!next.empty()) {
    const int i = next.back();
    next.pop_back();
    const int first = std::max(0, i - model.stiffness.half_bandwidth());
    const int last = std::min(model.dof_count() - 1, i + model.stiffness.half_bandwidth());
    for (int j = first; j <= last; ++j) {
      const bool waits = state[static_cast<std::size_t>(j)] == at_rest;
      if (waits && (joins(model.stiffness, i, j) || joins(model.mass, i, j))) reach(j);
    }
  }
  std::vector<int> dof;
  for (const int i : model.free_dof)
    if (state[static_cast<std::size_t>(i)] == reached) dof.push_back(i);
  return dof.empty() ? model.free_dof : dof;
}

/// Leaves out the diagonals of both that hold nothing.
void narrow(BandMatrix& a, BandMatrix& b) {
  long height = a.lower.rows();
  while (height > 1 && a.lower.row(height - 1).isZero(0.0) && b.lower.row(height - 1).isZero(0.0)) --height;
  a.lower.conservativeResize(height, Eigen::NoChange);
  b.lower.conservativeResize(height, Eigen::NoChange);
}

HarmonicProblem::Part part_of(const Terminal& terminal, const std::vector<int>& dof) {
  if (!terminal.at_support) return {false, {}, {}, terminal.vector(dof)};
  return {true, terminal.k(dof), terminal.m(dof), {}};
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

HarmonicProblem::HarmonicProblem(const Model& model, const Drive& driven, const Measurement& measurement) {
  const Terminal in = drive_terminal(model, driven);
  dof = reached_dof(model, in);
  stiffness = submatrix(model.stiffness, dof);
  mass = submatrix(model.mass, dof);
  narrow(stiffness, mass);
  drive = part_of(in, dof);
  for (const Terminal& out : output_terminals(model, measurement)) {
    outputs.push_back(part_of(out, dof));
    direct.push_back(direct_part(in, out));
  }
}

}  // namespace struna::fem
