#pragma once

#include <Eigen/Core>

#include "fem/drive.hpp"
#include "fem/eigenmodes.hpp"

namespace struna::fem {

/// Output over drive, per line and output: force/motion [N/m], displacement/force [m/N], displacement/motion
/// or force/force [-].
struct HarmonicResponse {
  Eigen::VectorXd frequency_hz;  ///< > 0
  Eigen::MatrixXcd response;     ///< lines x outputs
  Eigen::MatrixXd
      mesh_error;  ///< estimated |error| of the mesh at hand, same shape; empty when not asked for
};

struct HarmonicOptions {
  Damping damping = Damping::structural;
  bool estimate_mesh_error = false;  ///< solves on twice the elements as well: |difference| 16/15
};

/// Steady state (6), (7): K = E(f) K1 (1 + i eta(f)) or C = alpha M + beta K; prescribed dof partitioned, C
/// acting on absolute velocities. Few lines: one complex banded factorisation each; many lines of one mesh:
/// the sum over all its modes, which both damping models leave uncoupled (ModalSum). Throws Error where a
/// drive or measured support is not held in the driven or measured direction, or a frequency is not positive.
HarmonicResponse harmonic_response(const Model& model, const Drive& drive, const Measurement& measurement,
                                   const Eigen::VectorXd& frequency_hz, const HarmonicOptions& options = {});

/// Modal constants of the same function in the form in which a hysteretic mode is an exact circle: apparent
/// mass (force/motion), receptance (displacement/force). modes x outputs, real; omega_r from the modulus law.
/// Through a support H = ... + C_r (1 + i eta)/(omega_r^2(1 + i eta) - omega^2), for force/motion
/// C_r = omega_r^2 G_out G_in with G the participation; for displacement/force H = ... + C_r/(...),
/// C_r = phi_out phi_in (docs/harmonic.md).
Eigen::MatrixXd modal_constants(const Model& model, const Eigenmodes& modes, const Drive& drive,
                                const Measurement& measurement, const FrequencyLaw& youngs_modulus);

}  // namespace struna::fem
