#include "fem/modal_sum.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Eigen::VectorXd;

/// A drive or an output as the modes see it.
struct Seen {
  VectorXd shape;    ///< static shape of the dof for a unit motion of the supports; empty for a point
  VectorXd load;     ///< what inertia makes of it: m + M shape; the point's vector
  VectorXd weights;  ///< of the modes: phi^T load
};

Seen seen(const HarmonicProblem::Part& part, const HarmonicProblem& problem, const ShiftedModes& modes) {
  if (!part.at_support) return {{}, part.point, modes.shape.transpose() * part.point};
  VectorXd shape = -(part.k + modes.shift * part.m);
  modes.stiffness.solve(shape);
  VectorXd load = part.m + multiply(problem.mass, shape);
  VectorXd weights = modes.shape.transpose() * load;
  return {std::move(shape), std::move(load), std::move(weights)};
}

}  // namespace

ShiftedModes shifted_modes(const HarmonicProblem& problem, const Body& body) {
  ShiftedModes modes;
  modes.shift = clamped_eigenvalue(body);
  const BandMatrix shifted{problem.stiffness.lower + modes.shift * problem.mass.lower};
  // M phi = theta (K1 + shift M) phi, theta = 1/mu.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(problem.mass.dense(),
                                                                         shifted.dense());
  const bool definite = modes.stiffness.factorise(problem.stiffness, 1.0, problem.mass, modes.shift);
  if (!definite || solver.info() != Eigen::Success || !(solver.eigenvalues()(0) > 0.0))
    throw Error(fmt::format("harmonic_response: the modes of body '{}' were not found; use fewer elements",
                            body.name));
  const VectorXd& theta = solver.eigenvalues();
  modes.eigenvalue = theta.array().inverse();
  modes.shape = solver.eigenvectors() * theta.cwiseSqrt().cwiseInverse().asDiagonal();
  return modes;
}

// With the shifted stiffness K = K1 + shift M, which is definite for any body, s_k K1 + s_m M = s_k K + tau
// M, tau = s_m - shift s_k. A support's unit motion takes the free dof along by its static shape T, K T = -k;
// the rest of their motion is v = -tau (s_k K + tau M)^-1 p with p = m + M T, and a force read at a support
// with shape T_o and load p_o sees it as tau (T_o p + p_o v).
ModalSum::ModalSum(const ShiftedModes& modes, const HarmonicProblem& problem)
    : shift_(modes.shift),
      driven_at_support_(problem.drive.at_support),
      shifted_eigenvalue_(modes.eigenvalue) {
  const Seen in = seen(problem.drive, problem, modes);
  constants_.resize(static_cast<long>(problem.outputs.size()), modes.eigenvalue.size());
  for (std::size_t k = 0; k < problem.outputs.size(); ++k) {
    const HarmonicProblem::Part& part = problem.outputs[k];
    const HarmonicProblem::Direct& direct = problem.direct[k];
    const Seen out = seen(part, problem, modes);
    constants_.row(static_cast<long>(k)) = out.weights.cwiseProduct(in.weights);
    Output output{part.at_support, 0.0, 0.0, direct.constant};
    if (part.at_support && driven_at_support_) {
      output.stiffness = direct.k + shift_ * direct.m + (part.k + shift_ * part.m).dot(in.shape);
      output.mass = direct.m + part.m.dot(in.shape) + out.shape.dot(in.load);
    } else if (driven_at_support_) {
      output.constant += part.point.dot(in.shape);
    } else if (part.at_support) {
      output.constant -= out.shape.dot(in.load);
    }
    outputs_.push_back(output);
  }
}

Eigen::VectorXcd ModalSum::response(const DynamicScales& scales) const {
  using Complex = std::complex<double>;
  const Complex tau = scales.mass - shift_ * scales.stiffness;
  const Eigen::ArrayXd re = scales.stiffness.real() * shifted_eigenvalue_ + tau.real();
  const Eigen::ArrayXd im = scales.stiffness.imag() * shifted_eigenvalue_ + tau.imag();
  const Eigen::ArrayXd size = re.square() + im.square();
  const VectorXd real = constants_ * (re / size).matrix();
  const VectorXd imag = constants_ * (im / size).matrix();
  Eigen::VectorXcd response(static_cast<long>(outputs_.size()));
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    const Output& output = outputs_[k];
    const long at = static_cast<long>(k);
    const Complex factor =
        (driven_at_support_ ? -tau : Complex(1.0)) * (output.at_support ? tau : Complex(1.0));
    response(at) = scales.stiffness * output.stiffness + tau * output.mass + output.constant +
                   factor * Complex(real(at), -imag(at));
  }
  return response;
}

}  // namespace struna::fem
