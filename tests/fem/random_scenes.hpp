#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "fem/eigenmodes.hpp"
#include "fem/harmonic.hpp"

// Random bodies with what is asked of them, seeded: the sizing tests and the sizing benchmark draw the same
// ones.
namespace struna::fem::testing {

struct RandomScene {
  Body body;
  Drive drive;
  Measurement measurement;
  double lo_hz = 0.0;
  double hi_hz = 0.0;
  double tolerance = 0.0;
  Damping damping = Damping::structural;
};

/// Numbers that are the same with every standard library, unlike those of std::uniform_real_distribution.
class Dice {
 public:
  explicit Dice(unsigned seed) : generator_(seed) {}
  double uniform(double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(generator_()) + 0.5) / 4294967296.0;
  }
  double logarithmic(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }

 private:
  std::mt19937 generator_;
};

/// A third straight, a third arcs of 5 to 200 degrees, a third splines in space.
inline Centreline random_centreline(Dice& dice, double length) {
  const double kind = dice.uniform(0.0, 3.0);
  if (kind < 1.0) return straight_line({0.0, 0.0, 0.0}, {length, 0.0, 0.0});
  if (kind < 2.0) return circular_arc(length, dice.uniform(5.0, 200.0) * std::numbers::pi / 180.0);
  std::vector<Eigen::Vector3d> points = {Eigen::Vector3d::Zero()};
  const double height = dice.uniform(0.02, 0.25);
  for (int i = 1; i < 5; ++i) {
    points.emplace_back(0.25 * i, dice.uniform(-height, height), dice.uniform(-height, height));
  }
  return spline_through(points, length);
}

inline FrequencyLaw random_modulus(Dice& dice, double hi_hz) {
  const double value = dice.logarithmic(1e9, 2e11);
  const double kind = dice.uniform(0.0, 3.0);
  if (kind < 1.0) return constant_law(value);
  FrequencyLaw law;
  if (kind < 2.0) {
    law.kind = FrequencyLaw::Kind::power;
    law.parameters = {value, dice.uniform(0.0, 0.15), hi_hz};
    return law;
  }
  law.kind = FrequencyLaw::Kind::fractional_zener;
  law.parameters = {value, dice.uniform(1.0, 2.0), dice.uniform(0.2, 2.0) * hi_hz, dice.uniform(0.3, 1.0)};
  return law;
}

/// Shaken at a support, or driven by a force at a point; read at the other support, or at a point.
inline void random_drive(Dice& dice, RandomScene& scene) {
  const Eigen::Vector3d direction(0.0, std::cos(dice.uniform(0.0, 1.5)), std::sin(dice.uniform(0.0, 1.5)));
  if (dice.chance(0.7)) {
    scene.drive = SupportMotion{{End::start}, direction.normalized()};
  } else {
    scene.drive = PointForce{dice.uniform(0.1, 0.9), direction.normalized()};
  }
  scene.measurement.directions = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                  Eigen::Vector3d::UnitZ()};
  if (dice.chance(0.7)) {
    scene.measurement.what = SupportForce{End::end};
  } else {
    scene.measurement.what = PointDisplacement{dice.uniform(0.1, 0.9)};
  }
}

inline RandomScene random_scene(unsigned seed) {
  Dice dice(seed);
  const double length = dice.logarithmic(0.1, 2.0);
  // Slender enough that the band's shortest wave is some fifteen diameters long: beam theory holds.
  const double last_mode = dice.uniform(1.6, 12.5);
  const double wave = (last_mode + 0.5) * std::numbers::pi;
  const double diameter = length / std::max(dice.logarithmic(50.0, 400.0), wave / 0.4);
  RandomScene scene{.body = {.name = "wire",
                             .centreline = random_centreline(dice, length),
                             .section = solid_circle(diameter),
                             .material = {}},
                    .drive = {},
                    .measurement = {}};
  scene.body.density = dice.uniform(1000.0, 9000.0);
  if (dice.chance(0.2)) scene.body.end = EndCondition::pinned;
  scene.body.material.youngs_modulus = random_modulus(dice, 500.0);
  const double eigenvalue = clamped_eigenvalue(scene.body) * std::pow(wave / 4.730040744862704, 4);
  scene.hi_hz = natural_frequency_hz(eigenvalue, scene.body.material.youngs_modulus);
  scene.lo_hz = scene.hi_hz * dice.uniform(0.003, 0.1);
  scene.tolerance = dice.logarithmic(1e-4, 1e-2);
  const double loss_factor = dice.logarithmic(0.003, 0.3);
  if (dice.chance(0.3)) {
    scene.damping = Damping::viscous;
    scene.body.material.damping = Damping::viscous;
    const double omega = 2.0 * std::numbers::pi * scene.hi_hz;
    const double share = dice.uniform(0.0, 1.0);
    scene.body.material.rayleigh = {share * loss_factor * 0.1 * omega, (1.0 - share) * loss_factor / omega};
  } else if (dice.chance(0.5)) {
    scene.body.material.loss_factor = {FrequencyLaw::Kind::power,
                                       {loss_factor, dice.uniform(-0.1, 0.2), 0.5 * scene.hi_hz},
                                       {},
                                       {},
                                       0.0,
                                       0.0};
  } else {
    scene.body.material.loss_factor = constant_law(loss_factor);
  }
  random_drive(dice, scene);
  return scene;
}

}  // namespace struna::fem::testing
