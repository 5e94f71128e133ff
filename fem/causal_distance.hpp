#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fem/body_dynamics.hpp"
#include "fem/model.hpp"
#include "fem/scene.hpp"

namespace struna::fem {

/// Outputs over u at each frequency of a body in its modes, as its poles give them: the steady state that
/// exact stepping converges to. Lines x rows.
Eigen::MatrixXcd pole_response(const ModalBody& body, const std::vector<OutputRow>& rows,
                               const Eigen::VectorXd& frequency_hz);

/// Median of |a/b - 1| over lines and outputs; outputs below 1e-6 of the largest (rms) are left out.
double median_distance(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// Relative rms of a - b over lines and outputs, under a drive of the amplitudes given (lines); the lines need
/// not be evenly spaced (increasing, [Hz]): the rms is an integral over frequency. One line: |a - b|/|b|.
double rms_distance(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b, const Eigen::VectorXd& drive,
                    const Eigen::VectorXd& frequency_hz);

/// How far the causal law by which a structurally damped body is stepped keeps from the harmonic response
/// with E(f)(1 + i eta(f)): rms over the band and all outputs, relative, under a motion of flat acceleration
/// (a flat force). None where there is nothing to compare: viscous or no damping, or a drive on another body.
/// docs/pole_system.md.
std::optional<double> causal_distance(const Scene& scene, const Model& measured, const ModalBody& body,
                                      const std::vector<OutputRow>& rows, double lo_hz, double hi_hz);

}  // namespace struna::fem
