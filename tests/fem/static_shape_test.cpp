#include "fem/static_shape.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

Body wire(EndCondition start, EndCondition end) {
  Body body{"wire", straight_line({0, 0, 0}, {0.68, 0, 0}), solid_circle(0.0032), 7650.0, 0.3, {}, 12, start,
            end};
  body.material.youngs_modulus = constant_law(120e9);
  return body;
}

TEST(StaticShape, OfAClampedBeamIsTheCubic) {
  const auto model = assemble(wire(EndCondition::clamped, EndCondition::clamped));
  const auto shape = static_shape(model, solve_eigenmodes(model), {End::start}, Eigen::Vector3d::UnitY());
  for (std::size_t node = 0; node < model.arc_length.size(); ++node) {
    const double x = model.arc_length[node] / 0.68;
    // Rounding of the modal sum: eps times the ratio of the largest to the smallest eigenvalue, 1e9 here.
    EXPECT_NEAR(shape[6 * static_cast<long>(node) + 1], 1.0 - 3.0 * x * x + 2.0 * x * x * x, 1e-7) << node;
  }
}

TEST(StaticShape, OfBothSupportsIsARigidTranslation) {
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, -1).normalized();
  const auto model = assemble(wire(EndCondition::clamped, EndCondition::pinned));
  const auto shape = static_shape(model, solve_eigenmodes(model), {End::start, End::end}, direction);
  for (std::size_t node = 0; node < model.arc_length.size(); ++node) {
    EXPECT_LT((shape.segment<3>(6 * static_cast<long>(node)) - direction).norm(), 1e-9);  // rounding
    EXPECT_LT(shape.segment<3>(6 * static_cast<long>(node) + 3).norm(), 1e-9);
  }
}

TEST(StaticShape, LeavesNoForceOnFreeDof) {
  for (const auto start : {EndCondition::clamped, EndCondition::pinned}) {
    for (const auto end : {EndCondition::clamped, EndCondition::pinned, EndCondition::free}) {
      const auto model = assemble(wire(start, end));
      const auto shape = static_shape(model, solve_eigenmodes(model), {End::start}, Eigen::Vector3d::UnitZ());
      const Eigen::VectorXd force = multiply(model.stiffness, shape);
      // Rounding: eps times the axial stiffness of an element (1.4e-4 m per unit modulus), some 100 times.
      EXPECT_LT(force(model.free_dof).cwiseAbs().maxCoeff(), 1e-14 * 1e3 * model.stiffness.lower.maxCoeff());
      EXPECT_DOUBLE_EQ(shape[first_dof(model, End::start) + 2], 1.0);
    }
  }
}

TEST(StaticShape, NothingMovedIsNoMotionAndFreeEndsAreRefused) {
  const auto model = assemble(wire(EndCondition::clamped, EndCondition::free));
  const auto modes = solve_eigenmodes(model);
  EXPECT_EQ(static_shape(model, modes, {}, Eigen::Vector3d::UnitY()).norm(), 0.0);
  EXPECT_THROW(static_shape(model, modes, {End::end}, Eigen::Vector3d::UnitY()), Error);
}

}  // namespace
}  // namespace struna::fem
