#include "fem/harmonic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "fem/modal_sum.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
using Eigen::VectorXd;

void check_frequencies(const VectorXd& frequency_hz) {
  for (const double f : frequency_hz) {
    if (!(f > 0.0 && std::isfinite(f))) {
      throw Error(fmt::format("harmonic_response: frequencies must be positive, got {:g} Hz", f));
    }
  }
}

template <class Vectors>
void set_load(const HarmonicProblem& problem, const DynamicScales& scales, int lane, Vectors& b) {
  const HarmonicProblem::Part& drive = problem.drive;
  for (long i = 0; i < problem.mass.lower.cols(); ++i) {
    const Complex value = drive.at_support ? -(scales.stiffness * drive.k(i) + scales.mass * drive.m(i))
                                           : Complex(drive.point(i));
    b.re(lane, i) = value.real();
    b.im(lane, i) = value.imag();
  }
}

/// An output over the drive from one lane's solution.
template <class Vectors>
Complex output_of(const HarmonicProblem& problem, std::size_t output, const DynamicScales& scales, int lane,
                  const Vectors& x) {
  const HarmonicProblem::Part& part = problem.outputs[output];
  const HarmonicProblem::Direct& direct = problem.direct[output];
  const auto along = [&](const VectorXd& weight) {
    return Complex(x.re.row(lane).matrix().dot(weight), x.im.row(lane).matrix().dot(weight));
  };
  if (!part.at_support) return along(part.point) + direct.constant;
  return scales.stiffness * (along(part.k) + direct.k) + scales.mass * (along(part.m) + direct.m) +
         direct.constant;
}

[[noreturn]] void refuse_resonance(const Body& body, double f_hz) {
  throw Error(fmt::format(
      "harmonic_response: body '{}' has no damping and resonates at {:.9g} Hz; give it a loss factor",
      body.name, f_hz));
}

/// The lines, `lanes` of them at a time, each by a factorisation.
template <int lanes>
Eigen::MatrixXcd solve_lines(const HarmonicProblem& problem, const Body& body, const VectorXd& frequency_hz,
                             Damping damping) {
  using Solver = ComplexBandSolver<lanes>;
  Solver solver(problem.stiffness, problem.mass);
  const long lines = frequency_hz.size();
  const long unknowns = problem.mass.lower.cols();
  typename Solver::Vectors x{typename Solver::Lanes(lanes, unknowns),
                             typename Solver::Lanes(lanes, unknowns)};
  Eigen::MatrixXcd response(lines, static_cast<long>(problem.outputs.size()));
  for (long first = 0; first < lines; first += lanes) {
    std::array<DynamicScales, lanes> scales;
    typename Solver::Scales stiffness_scale;
    typename Solver::Scales mass_scale;
    bool undamped = false;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      // The last batch is filled up with the last line.
      const long line = std::min(first + static_cast<long>(lane), lines - 1);
      scales[lane] = dynamic_scales(body.material, damping, frequency_hz(line));
      stiffness_scale[lane] = scales[lane].stiffness;
      mass_scale[lane] = scales[lane].mass;
      undamped = undamped || (scales[lane].stiffness.imag() == 0.0 && scales[lane].mass.imag() == 0.0);
      set_load(problem, scales[lane], static_cast<int>(lane), x);
    }
    const int singular = solver.factorise(stiffness_scale, mass_scale);
    if (singular >= 0) refuse_resonance(body, frequency_hz(std::min(first + singular, lines - 1)));
    solver.solve(x, undamped);
    for (std::size_t lane = 0; lane < lanes && first + static_cast<long>(lane) < lines; ++lane) {
      for (std::size_t k = 0; k < problem.outputs.size(); ++k) {
        response(first + static_cast<long>(lane), static_cast<long>(k)) =
            output_of(problem, k, scales[lane], static_cast<int>(lane), x);
      }
    }
  }
  return response;
}

/// The lines as the sum over all modes.
Eigen::MatrixXcd sum_modes(const ModalSum& sum, const Body& body, const VectorXd& frequency_hz,
                           Damping damping, long outputs) {
  Eigen::MatrixXcd response(frequency_hz.size(), outputs);
  for (long line = 0; line < frequency_hz.size(); ++line) {
    response.row(line) = sum.response(dynamic_scales(body.material, damping, frequency_hz(line)));
    if (!response.row(line).allFinite()) refuse_resonance(body, frequency_hz(line));
  }
  return response;
}

/// Whether all modes and a sum over them take less time than a factorisation per line: the modes cost the
/// cube of the unknowns, a factorisation their number and, between 4 and 12 entries, the band's width
/// (measured).
bool modes_are_cheaper(long lines, const HarmonicProblem& problem) {
  constexpr double unknowns_squared_per_line = 100.0;
  constexpr double beam_in_space = 12.0;
  const auto unknowns = static_cast<double>(problem.mass.lower.cols());
  const double band = static_cast<double>(problem.mass.lower.rows()) / beam_in_space;
  return static_cast<double>(lines) * band > unknowns * unknowns / unknowns_squared_per_line;
}

Eigen::MatrixXcd solve(const Model& model, const Drive& drive, const Measurement& measurement,
                       const VectorXd& frequency_hz, Damping damping) {
  const long lines = frequency_hz.size();
  ShiftedModes modes;
  std::vector<int> dof_of_modes;  // references that reach the same dof share them
  Eigen::MatrixXcd response(lines, static_cast<long>(measurement.directions.size()));
  for (const Reference& reference : references_of(drive, measurement)) {
    const HarmonicProblem problem(model, reference.drive, reference.measurement);
    const auto solved = [&]() -> Eigen::MatrixXcd {
      if (modes_are_cheaper(lines, problem)) {
        if (dof_of_modes != problem.dof) modes = shifted_modes(problem, model.body);
        dof_of_modes = problem.dof;
        return sum_modes(ModalSum(modes, problem), model.body, frequency_hz, damping,
                         static_cast<long>(problem.outputs.size()));
      }
      // A line alone would leave three of four lanes idle.
      if (lines == 1) return solve_lines<1>(problem, model.body, frequency_hz, damping);
      return solve_lines<4>(problem, model.body, frequency_hz, damping);
    };
    response(Eigen::all, reference.outputs) = solved();
  }
  return response;
}

}  // namespace

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
  const Terminal in = drive_terminal(model, drive);
  const std::vector<Terminal> outputs = output_terminals(model, measurement);
  // A mode's weight in a drive or an output: its displacement, or its participation in a support's motion,
  // -(K1 phi/lambda - M phi) at the support, which is also what its inertia asks of that support.
  const auto weight = [&](const Terminal& f, long r) {
    const VectorXd shape = modes.shape.col(r);
    if (!f.at_support) return shape.dot(f.vector);
    return shape.dot(f.m) - shape.dot(f.k) / modes.eigenvalue(r);
  };
  Eigen::MatrixXd constants(modes.eigenvalue.size(), static_cast<long>(outputs.size()));
  for (long r = 0; r < modes.eigenvalue.size(); ++r) {
    const bool rigid = is_rigid(model.body, modes.eigenvalue(r));
    const double omega = 2.0 * std::numbers::pi * natural_frequency_hz(modes.eigenvalue(r), youngs_modulus);
    for (long k = 0; k < constants.cols(); ++k) {
      const Terminal& out = outputs[static_cast<std::size_t>(k)];
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
