#include "fem/body_dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/causal_distance.hpp"
#include "fem/error.hpp"
#include "fem/harmonic.hpp"
#include "fem/static_shape.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;
constexpr double two_pi = 2.0 * std::numbers::pi;

/// The curved wire of sample_data/curved_wire.
Body curved_wire(const Material& material) {
  Body body{"wire",
            spline_through(
                {{0, 0, 0}, {0.18, 0.06, 0.01}, {0.36, 0.02, 0.09}, {0.52, -0.05, 0.13}, {0.62, -0.02, 0.16}},
                0.68),
            {8.042477e-6, 3.1083e-12, 6.2166e-12},
            7650.0,
            0.3,
            material,
            30,
            EndCondition::clamped,
            EndCondition::clamped};
  return body;
}

Material viscous_material() {
  Material material;
  material.youngs_modulus = constant_law(100e9);
  material.rayleigh = {43.1, 2e-6};
  material.damping = Damping::viscous;
  return material;
}

/// E = 1.018e11 (f/100)^0.02 with a loss factor of 0.0374: more loss than causality gives such a modulus.
Material strand() {
  Material material;
  material.youngs_modulus = {FrequencyLaw::Kind::power, {1.0187e11, 0.02, 100.0}, {}, {}, 0.0, 0.0};
  material.loss_factor = constant_law(0.0374);
  return material;
}

Scene scene_of(const Body& body, const std::variant<Support, BodyPoint>& drive,
               const std::variant<Support, BodyPoint>& measured) {
  Scene scene;
  scene.bodies = {body};
  scene.drive = SceneDrive{drive, Eigen::Vector3d::UnitY(), {}};
  scene.measurement =
      SceneMeasurement{measured,
                       MotionQuantity::displacement,
                       {"x", "y", "z"},
                       {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}};
  return scene;
}

Eigen::MatrixXcd pole_response(const Scene& scene, const Eigen::VectorXd& frequency_hz) {
  const Model model = assemble(scene.bodies[0]);
  const auto modes = solve_eigenmodes(model);
  const auto drive = body_drive(scene, model);
  const auto coordinates = modal_coordinates(model, modes, drive);
  const auto body = modal_body(model, modes, coordinates, drive, 1000.0);
  const auto rows = output_rows(*scene.measurement, model, modes, coordinates, drive, {}, 0);
  return pole_response(body, rows, frequency_hz);
}

Eigen::MatrixXcd harmonic(const Scene& scene, const Eigen::VectorXd& frequency_hz) {
  const auto path = linear_path(scene);
  return harmonic_response(assemble(path.body), path.drive, path.measurement, frequency_hz,
                           {path.body.material.damping, false})
      .response;
}

/// Largest |a - b| of an output over that output's rms.
double distance(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b) {
  double worst = 0.0;
  for (long k = 0; k < b.cols(); ++k) {
    const double rms = b.col(k).norm() / std::sqrt(static_cast<double>(b.rows()));
    worst = std::max(worst, (a.col(k) - b.col(k)).cwiseAbs().maxCoeff() / rms);
  }
  return worst;
}

TEST(BodyDynamics, ViscousModesGiveTheHarmonicResponse) {
  const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(100, 10.0, 1000.0);
  const std::variant<Support, BodyPoint> start = Support{"wire", End::start};
  const std::variant<Support, BodyPoint> end = Support{"wire", End::end};
  const std::variant<Support, BodyPoint> point = BodyPoint{"wire", 0.37};
  for (const auto& drive : {start, point}) {
    for (const auto& measured : {start, end, point}) {
      const auto scene = scene_of(curved_wire(viscous_material()), drive, measured);
      // All modes are there: what is left is the rounding of the eigenvalue solver.
      EXPECT_LT(distance(pole_response(scene, lines), harmonic(scene, lines)), 1e-6)
          << drive.index() << ' ' << measured.index();
    }
  }
}

TEST(BodyDynamics, BothSupportsShakenTogetherAgreeToo) {
  const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(60, 10.0, 1000.0);
  auto scene =
      scene_of(curved_wire(viscous_material()), Support{"wire", End::start}, Support{"wire", End::end});
  scene.drive->also = {Support{"wire", End::end}};
  EXPECT_LT(distance(pole_response(scene, lines), harmonic(scene, lines)), 1e-6);  // rounding
}

TEST(BodyDynamics, CausalModesComeCloseToTheStructuralResponse) {
  const Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(1000, 10.0, 1000.0);
  const auto scene = scene_of(curved_wire(strand()), Support{"wire", End::start}, Support{"wire", End::end});
  const Eigen::MatrixXcd poles = pole_response(scene, lines);
  const Eigen::MatrixXcd exact = harmonic(scene, lines);
  // No causal law has E ~ f^0.02 with eta = 0.0374 (0.0314 belongs to it): 1 % median is what remains to be
  // asked.
  EXPECT_LT(median_distance(poles, exact), 0.01);
}

TEST(BodyDynamics, GravityLoadsTheSupportsWithTheWeight) {
  auto scene =
      scene_of(curved_wire(viscous_material()), Support{"wire", End::start}, Support{"wire", End::end});
  scene.simulation = Simulation{};
  scene.simulation->gravity = {0.0, 0.0, -9.81};
  const Model model = assemble(scene.bodies[0]);
  const auto modes = solve_eigenmodes(model);
  const auto drive = body_drive(scene, model);
  const auto coordinates = modal_coordinates(model, modes, drive);
  double support_force = 0.0;
  for (const End end : {End::start, End::end}) {
    scene.measurement->at = Support{"wire", end};
    support_force += output_rows(*scene.measurement, model, modes, coordinates, drive, {}, 0)[2].constant;
  }
  const double weight = 7650.0 * 8.042477e-6 * 0.68 * 9.81;
  EXPECT_NEAR(support_force, weight, 1e-6 * weight);  // rounding of the static shape's modal sum
}

TEST(BodyDynamics, ContactForcesArriveAtTheSupportsWithTheirStaticShare) {
  const auto scene =
      scene_of(curved_wire(viscous_material()), Support{"wire", End::start}, Support{"wire", End::end});
  const Model model = assemble(scene.bodies[0]);
  const auto modes = solve_eigenmodes(model);
  const auto drive = body_drive(scene, model);
  const auto coordinates = modal_coordinates(model, modes, drive);
  ContactPair pair;
  pair.inside_weights = Eigen::MatrixX2d::Zero(model.dof_count(), 2);
  pair.inside_weights.col(0) = point_functional(model, 0.4, Eigen::Vector3d::UnitY());
  pair.inside_weights.col(1) = point_functional(model, 0.4, Eigen::Vector3d::UnitZ());
  pair.outside_weights = Eigen::MatrixX2d::Zero(model.dof_count(), 2);
  double sum = 0.0;
  for (const End end : {End::start, End::end}) {
    auto measurement = *scene.measurement;
    measurement.at = Support{"wire", end};
    sum += output_rows(measurement, model, modes, coordinates, drive, {{pair, 0, 1}}, 0)[1].on_contact(0, 0);
  }
  EXPECT_NEAR(sum, -1.0, 1e-7);  // both supports together hold the force; rounding
}

TEST(ModulusMemory, FollowsASineAsTheLawSays) {
  const auto law = fit_maxwell_law(strand().youngs_modulus, constant_law(0.0374), 5.0, 1000.0);
  const double omega = two_pi * 50.0;
  const auto at = [&](double t) {
    return MotionSample{std::sin(omega * t), omega * std::cos(omega * t),
                        -omega * omega * std::sin(omega * t)};
  };
  ModulusMemory memory(law, at(0.0));
  const double h = 1e-5;
  double worst = 0.0;
  const Complex exact = law.at(Complex(0.0, omega));
  for (int i = 1; i <= 200000; ++i) {
    memory.advance(h, at(i * h));
    const Complex phasor = std::polar(1.0, omega * i * h);
    if (i > 100000) worst = std::max(worst, std::abs(memory.value() - (exact * phasor).imag()));
  }
  EXPECT_LT(worst / std::abs(exact),
            1e-6);  // (w h)^2/12 of a memory of a few percent, and what has not settled
}

}  // namespace
}  // namespace struna::fem
