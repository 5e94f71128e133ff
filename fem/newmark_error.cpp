#include "fem/newmark_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace struna::fem {
namespace {

constexpr double looks_per_period = 8.0;  ///< at the motion's highest frequency
constexpr std::size_t fewest_modes = 3;

/// Modes that may resonate, or nearly: their order as in the body.
std::vector<int> ringing_modes(const ModalBody& body, double highest_hz) {
  const Eigen::VectorXd& f = body.poles.natural_frequency_hz;
  std::vector<double> sorted(f.begin(), f.end());
  std::sort(sorted.begin(), sorted.end());
  const double third = sorted.size() < fewest_modes ? 0.0 : sorted[fewest_modes - 1];
  const double limit = std::max(2.0 * highest_hz, third);
  std::vector<int> chosen;
  for (int m = 0; m < f.size(); ++m)
    if (f[m] <= limit) chosen.push_back(m);
  return chosen;
}

/// These modes as degrees of freedom.
NodalBody uncoupled(const ModalBody& body, const std::vector<int>& chosen, const Rayleigh& rayleigh) {
  const Eigen::ArrayXd omega = 2.0 * std::numbers::pi * body.poles.natural_frequency_hz(chosen).array();
  NodalBody nodal;
  nodal.mass.lower = Eigen::MatrixXd::Ones(1, omega.size());
  nodal.stiffness.lower = omega.square().transpose().matrix();
  nodal.rayleigh = rayleigh;
  nodal.load = body.load(chosen, Eigen::all);
  return nodal;
}

Eigen::VectorXd load_at(const Eigen::MatrixX3d& load, const MotionSample& u) {
  return load.col(0) * u.displacement + load.col(1) * u.velocity + load.col(2) * u.acceleration;
}

}  // namespace

double newmark_error(const NewmarkOptions& options, const ModalBody& modes, const Rayleigh& rayleigh,
                     const PrescribedMotion& motion, double highest_hz, double duration) {
  const std::vector<int> chosen = ringing_modes(modes, highest_hz);
  const NodalBody nodal = uncoupled(modes, chosen, rayleigh);
  // A force drives through its own column, a moved support through the acceleration's.
  const int column = modes.load.col(2).isZero(0.0) ? 0 : 2;
  const Eigen::VectorXd all = modes.load.col(column);
  const Eigen::VectorXd weight = nodal.load.col(column);
  if (weight.isZero(0.0)) return 0.0;
  NewmarkStepper scheme({nodal}, {}, motion, options);
  ModalSteppingOptions finely;
  finely.longest_step = 1.0 / (40.0 * highest_hz);
  finely.highest_mode_hz = modes.poles.natural_frequency_hz(chosen).maxCoeff();
  ModalBody driven = modes;
  driven.constant_load.resize(0);  // gravity is held by statics in both
  ModalStepper exact({driven}, {}, motion, finely);
  const double interval =
      options.step * std::max(1.0, std::floor(1.0 / (looks_per_period * highest_hz * options.step)));
  double error = 0.0, size = 0.0;
  for (long look = 1; static_cast<double>(look) * interval <= duration; ++look) {
    const double t = static_cast<double>(look) * interval;
    scheme.advance(t);
    exact.advance(t);
    const Eigen::VectorXd force = exact.internal_force(0);
    const Eigen::VectorXd by_scheme = load_at(nodal.load, motion(t)) - scheme.acceleration(0);
    const Eigen::VectorXd exactly = force(chosen);
    const double apart = weight.dot(by_scheme - exactly);
    const double whole = all.dot(force);
    error += apart * apart;
    size += whole * whole;
  }
  return size > 0.0 ? std::sqrt(error / size) : 0.0;
}

}  // namespace struna::fem
