#include "fem/plane_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace struna::fem {
namespace {

Model straight(const Eigen::Vector3d& to, EndCondition end) {
  Body body{
      "wire", straight_line({0, 0, 0}, to), solid_circle(0.0032), 7650.0, 0.3, {}, 10, EndCondition::clamped,
      end};
  body.material.youngs_modulus = constant_law(120e9);
  return assemble(body);
}

TEST(PlaneModes, AreTheModesOfTheBody) {
  for (const Eigen::Vector3d& to : {Eigen::Vector3d(0.68, 0, 0), Eigen::Vector3d(0.3, 0.4, -0.2)}) {
    for (const auto end : {EndCondition::clamped, EndCondition::pinned, EndCondition::free}) {
      const auto model = straight(to, end);
      const auto modes = solve_plane_modes(model, Eigen::Vector3d::UnitY());
      const auto reference = solve_eigenmodes(model);
      ASSERT_EQ(modes.eigenvalue.size(), reference.eigenvalue.size());
      for (long r = 0; r < modes.eigenvalue.size(); ++r) {
        // Rounding of the eigenvalue solver: eps of the largest.
        EXPECT_NEAR(modes.eigenvalue[r], reference.eigenvalue[r], 1e-12 * reference.eigenvalue.maxCoeff())
            << r;
      }
      const Eigen::MatrixXd gram = modes.shape.transpose() * multiply(model.mass, modes.shape);
      EXPECT_LT((gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(PlaneModes, MoveInOnePlaneEach) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 0.4, -0.2).normalized();
  const Eigen::Vector3d drive = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d across = (drive - drive.dot(axis) * axis).normalized();
  const auto model = straight(0.68 * axis, EndCondition::clamped);
  const auto modes = solve_plane_modes(model, drive);
  int in_plane = 0;
  for (long r = 0; r < modes.eigenvalue.size(); ++r) {
    double along = 0.0, aside = 0.0;
    for (long dof = 0; dof < model.dof_count(); dof += 6) {
      const Eigen::Vector3d u = modes.shape.col(r).segment<3>(dof);
      along = std::max(along, std::abs(u.dot(across)));
      aside = std::max(aside, (u - u.dot(across) * across).norm());
    }
    if (along > 1e-6) ++in_plane;
    EXPECT_LT(std::min(along, aside), 1e-12 * std::max(along, aside) + 1e-300)
        << r;  // the groups are solved apart
  }
  EXPECT_EQ(in_plane, 18);  // 9 free nodes, deflection and slope
}

TEST(PlaneModes, LeaveACurvedBodyAlone) {
  Body body{"wire", circular_arc(0.68, 1.0), solid_circle(0.0032), 7650.0, 0.3, {},
            10,     EndCondition::clamped,   EndCondition::clamped};
  body.material.youngs_modulus = constant_law(120e9);
  const auto model = assemble(body);
  EXPECT_EQ(solve_plane_modes(model, Eigen::Vector3d::UnitY()).shape, solve_eigenmodes(model).shape);
}

TEST(PlaneModes, TheLowestOfThemAreTheFirstOfAll) {
  for (const int elements : {10, 60}) {  // a dense solver, and subspace iteration
    Body body = straight({0.68, 0, 0}, EndCondition::clamped).body;
    const auto model = assemble(body, elements);
    const auto all = solve_plane_modes(model, Eigen::Vector3d::UnitY());
    const auto few = solve_plane_modes(model, Eigen::Vector3d::UnitY(), 7);
    ASSERT_EQ(few.eigenvalue.size(), 7);
    ASSERT_EQ(few.shape.cols(), 7);
    for (long r = 0; r < 7; ++r) {
      // Rounding of the dense solver: eps of the largest eigenvalue.
      EXPECT_NEAR(few.eigenvalue[r], all.eigenvalue[r], 1e-14 * all.eigenvalue.maxCoeff());
    }
  }
}

}  // namespace
}  // namespace struna::fem
