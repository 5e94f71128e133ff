#pragma once

#include <numbers>

#include "fem/body.hpp"

// The bodies that several tests share: a clamped steel-like wire, 0.68 m, solid 3.2 mm.
namespace struna::fem::testing {

constexpr double wire_length = 0.68;
constexpr double wire_modulus = 120e9;

inline Body wire_along(const Centreline& centreline) {
  Body body{"wire",
            centreline,
            solid_circle(0.0032),
            7650.0,
            0.3,
            {},
            0,
            EndCondition::clamped,
            EndCondition::clamped};
  body.material.youngs_modulus = constant_law(wire_modulus);
  body.material.loss_factor = constant_law(0.02);
  return body;
}

inline Body straight_wire() {
  return wire_along(straight_line({0.0, 0.0, 0.0}, {wire_length, 0.0, 0.0}));
}

inline Body arc_wire(double degrees) {
  return wire_along(circular_arc(wire_length, degrees * std::numbers::pi / 180.0));
}

/// Points of a curve with inflections, in space.
inline std::vector<Eigen::Vector3d> spline_points() {
  return {{0.0, 0.0, 0.0}, {0.2, 0.05, 0.0}, {0.4, 0.0, 0.08}, {0.6, -0.05, 0.1}};
}

inline Body spline_wire() {
  return wire_along(spline_through(spline_points(), wire_length));
}

}  // namespace struna::fem::testing
