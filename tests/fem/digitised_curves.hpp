#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "fem/centreline.hpp"

// Curves with points read off them, for tests and benchmarks of what the points tell.
namespace struna::fem::testing {

/// `count` points equally far apart, each coordinate of the inner ones off by a normal error [m].
inline std::vector<Eigen::Vector3d> digitised(const Centreline& curve, int count, double error,
                                              unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d point = curve.at(curve.length() * i / (count - 1)).position;
    const bool inner = i > 0 && i + 1 < count;
    for (double& coordinate : point) coordinate += inner ? error * normal(engine) : 0.0;
    points.push_back(point);
  }
  return points;
}

/// A smooth space curve of 0.68 m: curvature in two directions across it by cosines and sines of up to
/// `waves` half waves over the length, with normal amplitudes, that turn by about `turn` [rad] in all.
inline Centreline wavy_curve(double turn, int waves, unsigned seed) {
  constexpr double length = 0.68;
  constexpr int steps = 20000, keep = 50;
  std::mt19937_64 engine(1000 + seed);
  std::normal_distribution<double> normal;
  std::vector<std::array<double, 4>> amplitude(static_cast<std::size_t>(waves) + 1);
  double power = 0.0;
  for (auto& a : amplitude) {
    a = {normal(engine), normal(engine), 0.7 * normal(engine), 0.7 * normal(engine)};
    for (const double value : a) power += 0.5 * value * value;
  }
  const double scale = turn / length / std::sqrt(power), step = length / steps;
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();  // tangent and two directions across
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points{at};
  for (int i = 0; i < steps; ++i) {
    const double phase = std::numbers::pi * (i + 0.5) / steps;
    Eigen::Vector2d curvature = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < amplitude.size(); ++k) {
      const double c = std::cos(static_cast<double>(k) * phase), s = std::sin(static_cast<double>(k) * phase);
      curvature += Eigen::Vector2d(amplitude[k][0] * c + amplitude[k][1] * s,
                                   amplitude[k][2] * c + amplitude[k][3] * s);
    }
    const Eigen::Vector3d rotation =
        step * scale * (curvature[0] * frame.col(2) - curvature[1] * frame.col(1));
    const Eigen::Vector3d before = frame.col(0);
    if (rotation.norm() > 0.0) frame = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()) * frame;
    at += step * (before + frame.col(0)).normalized();
    if ((i + 1) % keep == 0) points.push_back(at);
  }
  return spline_through(points, length);
}

}  // namespace struna::fem::testing
