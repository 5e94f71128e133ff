#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/body.hpp"
#include "fem/lane.hpp"

namespace struna::fem {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Matrix3x12 = Eigen::Matrix<double, 3, 12>;

/// Element matrices in global axes, dof order u v w rx ry rz at the first, then at the second node.
/// Stiffness for unit Young's modulus (G = 1/2(1+nu)); consistent mass.
struct ElementMatrices {
  Matrix12 stiffness;
  Matrix12 mass;
};

/// Curved Euler-Bernoulli beam element over arc length [s0, s1] of the body's centreline.
///
/// Its shape functions are the exact static ones of the curved element: the end flexibility is the integral
/// of the section compliance times the equilibrium section forces, k follows from its inverse and rigid
/// motion, the mass is consistent with the displacements that go with unit end motions. On a straight element
/// this gives the Hermite matrices (1)-(2) to rounding; on a curve there is neither geometric error nor
/// membrane locking. Derivation and limits: docs/beam_element.md.
ElementMatrices beam_element(const Body& body, double s0, double s1);

using Matrix12L = Eigen::Matrix<Lane, 12, 12>;

/// Matrices of four elements in their lanes; of the symmetric matrices only the lower halves.
struct LaneElementMatrices {
  Matrix12L stiffness;
  Matrix12L mass;
};

/// beam_element for the elements `first` to `first + 3` between the nodes at `arc_length`, where the curve is
/// at `node`, at less than half the time of four calls. Lanes beyond the last element repeat it.
LaneElementMatrices beam_elements(const Body& body, const std::vector<double>& arc_length,
                                  const std::vector<Eigen::Vector3d>& node, int first);

/// The Hermite matrices (1)-(2) of a straight element of length `length` along the unit vector `tangent`, in
/// closed form. What beam_element gives on a straight centreline, to rounding.
ElementMatrices straight_beam_element(const Body& body, double length, const Eigen::Vector3d& tangent);

/// Shape functions of the element [s0, s1] at arc length s in it: displacement there = N q, q the twelve end
/// motions.
Matrix3x12 beam_displacement(const Body& body, double s0, double s1, double s);

}  // namespace struna::fem
