#include "fem/model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "fem/error.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd translation(const Model& model, const Vector3d& direction) {
  VectorXd q = VectorXd::Zero(model.dof_count());
  for (int node = 0; node < static_cast<int>(model.arc_length.size()); ++node)
    q.segment<3>(6 * node) = direction;
  return q;
}

TEST(Model, HasNodesAtEqualArcLengths) {
  const Model model = assemble(testing::spline_wire(), 10);
  ASSERT_EQ(model.arc_length.size(), 11u);
  EXPECT_EQ(model.dof_count(), 66);
  EXPECT_EQ(model.stiffness.half_bandwidth(), 11);
  EXPECT_DOUBLE_EQ(model.arc_length[3], 0.3 * model.body.centreline.length());
  EXPECT_TRUE(model.position[3].isApprox(model.body.centreline.at(model.arc_length[3]).position));
}

TEST(Model, TakesTheBodysElementsUnlessTold) {
  Body body = testing::straight_wire();
  body.elements = 7;
  EXPECT_EQ(assemble(body).arc_length.size(), 8u);
  EXPECT_EQ(assemble(body, 3).arc_length.size(), 4u);
  body.elements = 0;
  EXPECT_THROW(assemble(body), Error);
  EXPECT_THROW(assemble(body, -2), Error);
}

TEST(Model, EndConditionsHoldTheirDof) {
  Body body = testing::straight_wire();
  body.start = EndCondition::pinned;
  body.end = EndCondition::free;
  const Model model = assemble(body, 2);
  EXPECT_EQ(model.held_dof, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(model.free_dof.size(), 15u);
  body.end = EndCondition::clamped;
  EXPECT_EQ(assemble(body, 2).held_dof, (std::vector<int>{0, 1, 2, 12, 13, 14, 15, 16, 17}));
  EXPECT_EQ(first_dof(model, End::start), 0);
  EXPECT_EQ(first_dof(model, End::end), 12);
}

TEST(Model, TotalMassIsThatOfTheBodyWhateverTheCurve) {
  for (const Body& body : {testing::straight_wire(), testing::arc_wire(180.0), testing::spline_wire()}) {
    const Model model = assemble(body, 12);
    for (int i = 0; i < 3; ++i) {
      const VectorXd q = translation(model, Vector3d::Unit(i));
      EXPECT_NEAR(q.dot(multiply(model.mass, q).col(0)), 0.0418369663589737, 1e-15);  // rounding
    }
  }
}

TEST(Model, TipDeflectionOfACantileverIsExactOnAnyMesh) {
  // Straight: F L^3/(3 E I). On a curve the element is exact too: two meshes agree.
  Body body = testing::straight_wire();
  body.end = EndCondition::free;
  const auto tip = [](const Body& b, int elements) {
    const Model model = assemble(b, elements);
    const Eigen::MatrixXd k = submatrix(model.stiffness, model.free_dof).dense();
    VectorXd load = VectorXd::Zero(k.rows());
    load(k.rows() - 5) = 1.0;
    return k.llt().solve(load)(k.rows() - 5);
  };
  const double exact = std::pow(0.68, 3) / (3.0 * body.section.second_moment);
  EXPECT_NEAR(tip(body, 1) / exact, 1.0, 1e-12);
  EXPECT_NEAR(tip(body, 30) / exact, 1.0, 1e-9);  // rounding, growing with the number of elements
  Body arc = testing::arc_wire(90.0);
  arc.end = EndCondition::free;
  // Rounding: 1.5e-9 rms over meshes of 24 to 48 elements, for this one between 3e-10 and 1e-9 by compiler
  // options.
  EXPECT_NEAR(tip(arc, 8) / tip(arc, 31), 1.0, 1e-8);
}

TEST(Model, PointFunctionalIsExactAtNodesAndForRigidMotion) {
  const Model model = assemble(testing::spline_wire(), 10);
  const VectorXd node = point_functional(model, 0.3, Vector3d::UnitY());
  EXPECT_EQ(node(6 * 3 + 1), 1.0);
  EXPECT_EQ(node.cwiseAbs().sum(), 1.0);
  const VectorXd between = point_functional(model, 0.537, Vector3d::UnitZ());
  EXPECT_NEAR(between.dot(translation(model, Vector3d(0.0, 0.0, 2.0))), 2.0, 1e-12);
  EXPECT_NEAR(between.dot(translation(model, Vector3d(3.0, 1.0, 0.0))), 0.0, 1e-12);
  EXPECT_EQ(point_functional(model, 1.0, Vector3d::UnitX())(60), 1.0);
  EXPECT_THROW(point_functional(model, -0.1, Vector3d::UnitX()), Error);
  EXPECT_THROW(point_functional(model, 1.1, Vector3d::UnitX()), Error);
}

TEST(Model, RefusesAnUnsoundBody) {
  Body body = testing::straight_wire();
  body.density = -1.0;
  EXPECT_THROW(assemble(body, 4), Error);
}

}  // namespace
}  // namespace struna::fem
