#include "fem/causal_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "filter_scene.hpp"

namespace struna::fem {
namespace {

/// E = 1.018e11 (f/100)^n with a loss factor.
Material strand(double exponent, double loss_factor) {
  Material material;
  material.youngs_modulus = {FrequencyLaw::Kind::power, {1.0187e11, exponent, 100.0}, {}, {}, 0.0, 0.0};
  material.loss_factor = constant_law(loss_factor);
  return material;
}

SimulationReport report_of(const Scene& scene) {
  return simulated(scene).report;
}

TEST(CausalDistance, IsSmallForTheSampleMaterialAndSmallerForACausalOne) {
  auto scene = bare_scene(curved_wire(), Excitation::Kind::multisine, 0.01);
  // 0.0314 belongs to f^0.02: eta = (pi/2) n.
  scene.bodies[0].material = strand(0.02, 0.0374);
  const auto measured = report_of(scene).causal_distance;
  scene.bodies[0].material = strand(0.02, 0.0314);
  const auto causal = report_of(scene).causal_distance;
  ASSERT_TRUE(measured && causal);
  // 1 % is what a causal law is asked for. Of a causal pair only the fit's ripple remains.
  EXPECT_LT(*measured, 0.01);
  EXPECT_LT(*causal, 2e-3);
  EXPECT_GT(*measured, *causal);
}

TEST(CausalDistance, FarFromCausalIsTold) {
  // Much loss, and a modulus that does not rise at all.
  auto scene = bare_scene(curved_wire(), Excitation::Kind::multisine, 0.01);
  scene.bodies[0].material = strand(0.0, 0.3);
  const auto report = report_of(scene);
  ASSERT_TRUE(report.causal_distance);
  EXPECT_GT(*report.causal_distance, 0.05);
  bool told = false;
  for (const auto& warning : report.warnings) {
    told = told || warning.find("no causal material") != std::string::npos;
  }
  EXPECT_TRUE(told);
}

TEST(CausalDistance, NothingIsComparedWithoutALossFactor) {
  auto scene = bare_scene(curved_wire(), Excitation::Kind::multisine, 0.01);
  EXPECT_FALSE(report_of(scene).causal_distance);  // viscous
  scene.bodies[0].material = strand(0.0, 0.0);
  EXPECT_FALSE(report_of(scene).causal_distance);  // no loss at all
}

TEST(CausalDistance, MotionAtAPointIsComparedInItsOwnQuantity) {
  auto scene = bare_scene(curved_wire(), Excitation::Kind::multisine, 0.01);
  scene.bodies[0].material = strand(0.02, 0.0314);
  scene.measurement->at = BodyPoint{"wire", 0.4};
  for (const auto quantity :
       {MotionQuantity::displacement, MotionQuantity::velocity, MotionQuantity::acceleration}) {
    scene.measurement->quantity = quantity;
    const auto distance = report_of(scene).causal_distance;
    ASSERT_TRUE(distance);
    EXPECT_LT(*distance, 1e-3);
  }
}

TEST(CausalDistance, MedianLeavesOutOutputsThatDoNotRespond) {
  Eigen::MatrixXcd b = Eigen::MatrixXcd::Ones(5, 2);
  b.col(1).setConstant(1e-12);
  Eigen::MatrixXcd a = b * 1.01;
  a.col(1).setConstant(7.0);
  a(0, 0) = 3.0;  // one line off moves no median
  EXPECT_NEAR(median_distance(a, b), 0.01, 1e-12);
}

TEST(CausalDistance, RmsIsAnIntegralOverFrequency) {
  // |a - b| = 0.1 f under a drive of 1/f, b = 1: off = 0.1, all = integral of f^-2, on lines of any spacing.
  const auto distance = [](const Eigen::VectorXd& f) {
    const Eigen::MatrixXcd b = Eigen::MatrixXcd::Ones(f.size(), 1);
    const Eigen::MatrixXcd a = b + 0.1 * f.cast<std::complex<double>>();
    return rms_distance(a, b, f.cwiseInverse(), f);
  };
  const double expected = 0.1 * std::sqrt(2.0);  // (2 - 1)/(1 - 1/2) from 1 to 2 Hz
  const Eigen::VectorXd even = Eigen::VectorXd::LinSpaced(401, 1.0, 2.0);
  EXPECT_NEAR(distance(even), expected, 1e-5);  // trapezoidal rule
  EXPECT_NEAR(distance(Eigen::VectorXd((2.0 - even.array()).pow(3) + 1.0).reverse()), expected, 1e-4);
  EXPECT_NEAR(distance(Eigen::VectorXd::Constant(1, 3.0)), 0.3, 1e-12);
}

}  // namespace
}  // namespace struna::fem
