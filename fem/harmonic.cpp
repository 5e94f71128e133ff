#include "fem/harmonic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
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

/// A drive or an output as a vector over all dof: prescribed unit motion or the support dof that a force is
/// read at (`at_support`), else the load or the displacement functional.
struct Functional {
  VectorXd vector;
  bool at_support = false;
  VectorXd k;  ///< K1 vector, for those at a support
  VectorXd m;  ///< M vector

  void complete(const Model& model) {
    if (!at_support) return;
    k = multiply_sparse(model.stiffness, vector);
    m = multiply_sparse(model.mass, vector);
  }
};

Functional functional(const Model& model, const Drive& drive) {
  Functional f;
  if (const auto* motion = std::get_if<SupportMotion>(&drive)) {
    check_direction(motion->direction, "drive");
    if (motion->ends.empty())
      throw Error("harmonic_response: the drive must name at least one support, got none");
    f.vector = VectorXd::Zero(model.dof_count());
    f.at_support = true;
    for (const End end : motion->ends) add_support(model, end, motion->direction, "drive", f.vector);
  } else {
    const auto& force = std::get<PointForce>(drive);
    check_direction(force.direction, "drive");
    f.vector = point_functional(model, force.fraction, force.direction);
  }
  f.complete(model);
  return f;
}

std::vector<Functional> functionals(const Model& model, const Measurement& measurement) {
  if (measurement.directions.empty())
    throw Error("harmonic_response: at least one measured direction, got none");
  std::vector<Functional> all;
  for (const Vector3d& direction : measurement.directions) {
    check_direction(direction, "measurement");
    Functional f;
    if (const auto* support = std::get_if<SupportForce>(&measurement.what)) {
      f.vector = VectorXd::Zero(model.dof_count());
      f.at_support = true;
      add_support(model, support->end, direction, "measured support", f.vector);
    } else {
      f.vector = point_functional(model, std::get<PointDisplacement>(measurement.what).fraction, direction);
    }
    f.complete(model);
    all.push_back(std::move(f));
  }
  return all;
}

/// Factors of K1 and M in the dynamic stiffness: (6) with (9), or (7).
struct DynamicScales {
  Complex stiffness;
  Complex mass;
};

DynamicScales dynamic_scales(const Material& material, Damping damping, double f_hz) {
  const double omega = 2.0 * std::numbers::pi * f_hz;
  const double modulus = material.youngs_modulus.at(f_hz);
  if (damping == Damping::structural) {
    return {modulus * Complex(1.0, material.loss_factor.at(f_hz)), -omega * omega};
  }
  return {modulus * Complex(1.0, omega * material.rayleigh.beta),
          Complex(-omega * omega, omega * material.rayleigh.alpha)};
}

VectorXd pick(const VectorXd& all, const std::vector<int>& dof) {
  return all(dof);
}

/// Everything about one problem that does not depend on frequency, over the free dof.
class Problem {
 public:
  Problem(const Model& model, const Drive& drive, const Measurement& measurement)
      : stiffness_(submatrix(model.stiffness, model.free_dof)), mass_(submatrix(model.mass, model.free_dof)) {
    const Functional in = functional(model, drive);
    if (in.at_support) {
      drive_k_ = -pick(in.k, model.free_dof);
      drive_m_ = -pick(in.m, model.free_dof);
    } else {
      drive_load_ = pick(in.vector, model.free_dof);
    }
    for (const Functional& out : functionals(model, measurement)) outputs_.push_back(output(model, in, out));
  }

  const BandMatrix& stiffness() const { return stiffness_; }
  const BandMatrix& mass() const { return mass_; }
  long output_count() const { return static_cast<long>(outputs_.size()); }

  /// The right-hand side of one lane.
  template <class Vectors>
  void load(const DynamicScales& scales, int lane, Vectors& b) const {
    for (long i = 0; i < mass_.lower.cols(); ++i) {
      const Complex value = drive_load_.size() > 0
                                ? Complex(drive_load_(i))
                                : scales.stiffness * drive_k_(i) + scales.mass * drive_m_(i);
      b.re(lane, i) = value.real();
      b.im(lane, i) = value.imag();
    }
  }

  /// Output over drive from one lane's solution.
  template <class Vectors>
  Complex response(long index, const DynamicScales& scales, int lane, const Vectors& x) const {
    const Output& out = outputs_[static_cast<std::size_t>(index)];
    const auto along = [&](const VectorXd& weight) {
      return Complex(x.re.row(lane).matrix().dot(weight), x.im.row(lane).matrix().dot(weight));
    };
    if (!out.force) return along(out.displacement) + out.direct;
    return scales.stiffness * (along(out.k) + out.direct_k) + scales.mass * (along(out.m) + out.direct_m) +
           out.direct;
  }

 private:
  struct Output {
    bool force = false;
    VectorXd k;  ///< rows of K1 that a support's force sums
    VectorXd m;
    VectorXd displacement;  ///< weights of a displacement
    double direct_k = 0.0;  ///< contributions of the prescribed motion itself
    double direct_m = 0.0;
    double direct = 0.0;
  };

  static Output output(const Model& model, const Functional& in, const Functional& out) {
    Output o;
    o.force = out.at_support;
    if (o.force) {
      o.k = pick(out.k, model.free_dof);
      o.m = pick(out.m, model.free_dof);
      if (in.at_support) {
        o.direct_k = out.k.dot(in.vector);
        o.direct_m = out.m.dot(in.vector);
      } else {
        o.direct = -out.vector.dot(in.vector);  // the part of the load that goes straight into the support
      }
    } else {
      o.displacement = pick(out.vector, model.free_dof);
      if (in.at_support) o.direct = out.vector.dot(in.vector);
    }
    return o;
  }

  BandMatrix stiffness_;
  BandMatrix mass_;
  VectorXd drive_load_;
  VectorXd drive_k_;
  VectorXd drive_m_;
  std::vector<Output> outputs_;
};

void check_frequencies(const VectorXd& frequency_hz) {
  for (const double f : frequency_hz) {
    if (!(f > 0.0 && std::isfinite(f))) {
      throw Error(fmt::format("harmonic_response: frequencies must be positive, got {:g} Hz", f));
    }
  }
}

/// The lines, `lanes` of them at a time.
template <int lanes>
Eigen::MatrixXcd solve_lines(const Problem& problem, const Model& model, const VectorXd& frequency_hz,
                             Damping damping) {
  using Solver = ComplexBandSolver<lanes>;
  Solver solver(problem.stiffness(), problem.mass());
  const long lines = frequency_hz.size();
  const long unknowns = problem.mass().lower.cols();
  typename Solver::Vectors x{typename Solver::Lanes(lanes, unknowns),
                             typename Solver::Lanes(lanes, unknowns)};
  Eigen::MatrixXcd response(lines, problem.output_count());
  for (long first = 0; first < lines; first += lanes) {
    std::array<DynamicScales, lanes> scales;
    typename Solver::Scales stiffness_scale;
    typename Solver::Scales mass_scale;
    bool undamped = false;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      // The last batch is filled up with the last line.
      const long line = std::min(first + static_cast<long>(lane), lines - 1);
      scales[lane] = dynamic_scales(model.body.material, damping, frequency_hz(line));
      stiffness_scale[lane] = scales[lane].stiffness;
      mass_scale[lane] = scales[lane].mass;
      undamped = undamped || (scales[lane].stiffness.imag() == 0.0 && scales[lane].mass.imag() == 0.0);
      problem.load(scales[lane], static_cast<int>(lane), x);
    }
    const int singular = solver.factorise(stiffness_scale, mass_scale);
    if (singular >= 0) {
      throw Error(fmt::format(
          "harmonic_response: body '{}' has no damping and resonates at {:.9g} Hz; give it a loss factor",
          model.body.name, frequency_hz(std::min(first + singular, lines - 1))));
    }
    solver.solve(x, undamped);
    for (long lane = 0; lane < lanes && first + lane < lines; ++lane) {
      for (long k = 0; k < problem.output_count(); ++k) {
        response(first + lane, k) = problem.response(k, scales[lane], static_cast<int>(lane), x);
      }
    }
  }
  return response;
}

Eigen::MatrixXcd solve(const Model& model, const Drive& drive, const Measurement& measurement,
                       const VectorXd& frequency_hz, Damping damping) {
  Eigen::MatrixXcd response(frequency_hz.size(), static_cast<long>(measurement.directions.size()));
  for (const Reference& reference : references_of(drive, measurement)) {
    const Problem problem(model, reference.drive, reference.measurement);
    // A line alone would leave three of four lanes idle.
    response(Eigen::all, reference.outputs) = frequency_hz.size() == 1
                                                  ? solve_lines<1>(problem, model, frequency_hz, damping)
                                                  : solve_lines<4>(problem, model, frequency_hz, damping);
  }
  return response;
}

}  // namespace

std::vector<Reference> references_of(const Drive& drive, const Measurement& measurement) {
  const auto& along = measurement.drive_directions;
  if (along.empty()) {
    Reference all{drive, measurement, {}};
    for (std::size_t k = 0; k < measurement.directions.size(); ++k)
      all.outputs.push_back(static_cast<long>(k));
    return {all};
  }
  if (along.size() != measurement.directions.size())
    throw Error(fmt::format("references_of: a drive direction for each of the {} outputs, got {}",
                            measurement.directions.size(), along.size()));
  std::vector<Reference> references;
  std::vector<Vector3d> known;
  for (std::size_t k = 0; k < along.size(); ++k) {
    const auto at = std::find(known.begin(), known.end(), along[k]) - known.begin();
    if (at == static_cast<long>(known.size())) {
      known.push_back(along[k]);
      references.push_back({drive, {measurement.what, {}}, {}});
      std::visit([&](auto& driven) { driven.direction = along[k]; }, references.back().drive);
    }
    Reference& reference = references[static_cast<std::size_t>(at)];
    reference.measurement.directions.push_back(measurement.directions[k]);
    reference.outputs.push_back(static_cast<long>(k));
  }
  return references;
}

HarmonicResponse harmonic_response(const Model& model, const Drive& drive, const Measurement& measurement,
                                   const VectorXd& frequency_hz, const HarmonicOptions& options) {
  check_frequencies(frequency_hz);
  validate_modulus(model.body);
  if (model.free_dof.empty()) {
    throw Error(
        fmt::format("harmonic_response: body '{}' has no free dof; use more elements", model.body.name));
  }
  HarmonicResponse result{frequency_hz, solve(model, drive, measurement, frequency_hz, options.damping), {}};
  if (options.estimate_mesh_error) {
    const int elements = static_cast<int>(model.arc_length.size()) - 1;
    const Eigen::MatrixXcd finer =
        solve(assemble(model.body, 2 * elements), drive, measurement, frequency_hz, options.damping);
    // The error falls as h^4: coarse - fine = (1 - 1/16) of the coarse one's.
    result.mesh_error = 16.0 / 15.0 * (result.response - finer).cwiseAbs();
  }
  return result;
}

Eigen::MatrixXd modal_constants(const Model& model, const Eigenmodes& modes, const Drive& drive,
                                const Measurement& measurement, const FrequencyLaw& youngs_modulus) {
  if (!measurement.drive_directions.empty()) {
    Eigen::MatrixXd all(modes.eigenvalue.size(), static_cast<long>(measurement.directions.size()));
    for (const Reference& reference : references_of(drive, measurement))
      all(Eigen::all, reference.outputs) =
          modal_constants(model, modes, reference.drive, reference.measurement, youngs_modulus);
    return all;
  }
  const Functional in = functional(model, drive);
  const std::vector<Functional> outputs = functionals(model, measurement);
  // A mode's weight in a drive or an output: its displacement, or its participation in a support's motion,
  // -(K1 phi/lambda - M phi) at the support, which is also what its inertia asks of that support.
  const auto weight = [&](const Functional& f, long r) {
    const VectorXd shape = modes.shape.col(r);
    if (!f.at_support) return shape.dot(f.vector);
    return shape.dot(f.m) - shape.dot(f.k) / modes.eigenvalue(r);
  };
  Eigen::MatrixXd constants(modes.eigenvalue.size(), static_cast<long>(outputs.size()));
  for (long r = 0; r < modes.eigenvalue.size(); ++r) {
    const bool rigid = is_rigid(model.body, modes.eigenvalue(r));
    const double omega = 2.0 * std::numbers::pi * natural_frequency_hz(modes.eigenvalue(r), youngs_modulus);
    for (long k = 0; k < constants.cols(); ++k) {
      const Functional& out = outputs[static_cast<std::size_t>(k)];
      const bool through_support = in.at_support || out.at_support;
      // A rigid motion has no resonance; its share of a function through a support is part of the constant.
      if (rigid && through_support) {
        constants(r, k) = 0.0;
        continue;
      }
      const double sign = out.at_support && !in.at_support ? -1.0 : 1.0;
      constants(r, k) = sign * (through_support ? omega * omega : 1.0) * weight(in, r) * weight(out, r);
    }
  }
  return constants;
}

}  // namespace struna::fem
