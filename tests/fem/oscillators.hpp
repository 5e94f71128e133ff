#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <vector>

#include "fem/modal_stepping.hpp"

namespace struna::fem::testing {

inline MotionSample still(double) {
  return {};
}

/// Uncoupled oscillators q'' + 2 zeta omega q' + omega^2 q = p.
inline ModalBody oscillators(const std::vector<double>& omega, double zeta) {
  const int n = static_cast<int>(omega.size());
  ModalBody body;
  body.poles.modes = n;
  body.poles.pole.resize(n);
  body.poles.residue.resize(n);
  body.poles.mode.resize(n);
  for (int m = 0; m < n; ++m) {
    const double damped = omega[m] * std::sqrt(1.0 - zeta * zeta);
    body.poles.pole[m] = {-zeta * omega[m], damped};
    body.poles.residue[m] = {0.0, -1.0 / damped};
    body.poles.mode[m] = m;
  }
  body.load = Eigen::MatrixX3d::Zero(n, 3);
  return body;
}

/// A mass that is free but for a spring that returns it once in ten minutes.
inline ModalBody free_mass() {
  return oscillators({1e-2}, 0.0);
}

/// A wall at x = `at` for x = (q of the modes) . weights, moved 1 m away so that any `at` gives a positive
/// gap.
inline ContactPoint wall(const ContactForceLaw& law, double at, const std::vector<double>& weights) {
  ContactPoint point;
  point.law = law;
  point.gap = 1.0 + at;
  point.shape = StopShape::wall;
  point.rest_offset = {1.0, 0.0};
  point.inside = Eigen::MatrixX2d::Zero(static_cast<Eigen::Index>(weights.size()), 2);
  for (std::size_t m = 0; m < weights.size(); ++m) point.inside(static_cast<Eigen::Index>(m), 0) = weights[m];
  return point;
}

inline Eigen::VectorXd vector(std::initializer_list<double> values) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

/// A mass in the plane (two equal oscillators as its coordinates) inside a bore.
inline ModalStepper mass_in_bore(const ContactForceLaw& law, const ModalSteppingOptions& options) {
  ContactPoint point;
  point.law = law;
  point.gap = 1e-3;
  point.inside = Eigen::MatrixX2d::Identity(2, 2);
  return ModalStepper({oscillators({100.0, 170.0}, 0.0)}, {point}, still, options);
}

}  // namespace struna::fem::testing
