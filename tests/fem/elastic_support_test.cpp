// Supports that give: closed forms of the straight beam on springs, and the limits of stiff and soft springs.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

#include "fem/error.hpp"
#include "fem/harmonic.hpp"
#include "fem/static_shape.hpp"
#include "tests/fem/bodies.hpp"

namespace struna::fem {
namespace {

using Complex = std::complex<double>;

const double length = testing::wire_length;
const double bending = testing::wire_modulus * solid_circle(0.0032).second_moment;
const double mass_per_length = 7650.0 * solid_circle(0.0032).area;
const double turning = 20.0 * bending / length;                         // [N m/rad]
const double shifting = 3000.0 * bending / (length * length * length);  // [N/m]

Body wire(const ElasticSupport& start, const ElasticSupport& end) {
  Body body = testing::straight_wire();
  body.start_support = start;
  body.end_support = end;
  return body;
}

double frequency(const Body& body, int mode, int elements = 40) {
  const Model model = assemble(body, elements);
  return natural_frequencies_hz(body, solve_eigenmodes(model, mode + 1).eigenvalue)[mode];
}

struct Forces {
  Complex near;
  Complex far;
};

/// Forces that the supports exert on the body over the motion of the start's base: w = A cos bx + B sin bx +
/// C cosh bx + D sinh bx with EI w''(0) = k w'(0), EI w'''(0) = t (u - w(0)) + m omega^2 w(0), and the like
/// at the end; all springs with the loss factor of the body.
Forces closed_form(const ElasticSupport& start, const ElasticSupport& end, double f_hz, double loss_factor) {
  const double omega = 2.0 * std::numbers::pi * f_hz;
  const Complex scale(1.0, loss_factor);
  const Complex ei = bending * scale;
  const Complex b = std::pow(mass_per_length * omega * omega / ei, 0.25);
  const Complex x = b * length;
  Eigen::Matrix4cd a;
  const auto value = Eigen::RowVector4cd(std::cos(x), std::sin(x), std::cosh(x), std::sinh(x));
  const auto slope = (b * Eigen::RowVector4cd(-std::sin(x), std::cos(x), std::sinh(x), std::cosh(x))).eval();
  const auto bend =
      (b * b * Eigen::RowVector4cd(-std::cos(x), -std::sin(x), std::cosh(x), std::sinh(x))).eval();
  const auto shear =
      (b * b * b * Eigen::RowVector4cd(std::sin(x), -std::cos(x), std::sinh(x), std::cosh(x))).eval();
  const Complex inertia0 = start.mass * omega * omega, inertia1 = end.mass * omega * omega;
  a.row(0) = ei * b * b * Eigen::RowVector4cd(-1, 0, 1, 0) -
             start.rotation * scale * b * Eigen::RowVector4cd(0, 1, 0, 1);
  a.row(1) = ei * b * b * b * Eigen::RowVector4cd(0, -1, 0, 1) +
             (start.translation * scale - inertia0) * Eigen::RowVector4cd(1, 0, 1, 0);
  a.row(2) = ei * bend + end.rotation * scale * slope;
  a.row(3) = ei * shear - (end.translation * scale - inertia1) * value;
  const Eigen::Vector4cd w = a.fullPivLu().solve(Eigen::Vector4cd(0.0, start.translation * scale, 0.0, 0.0));
  return {start.translation * scale * (1.0 - (w[0] + w[2])), -end.translation * scale * (value * w)(0)};
}

Forces solved(const Body& body, double f_hz) {
  const Model model = assemble(body, 60);
  const SupportMotion drive{{End::start}, Eigen::Vector3d::UnitY()};
  const auto force = [&](End end) {
    return harmonic_response(model, drive, {SupportForce{end}, {Eigen::Vector3d::UnitY()}},
                             Eigen::VectorXd::Constant(1, f_hz))
        .response(0, 0);
  };
  return {force(End::start), force(End::end)};
}

TEST(ElasticSupport, ForcesOfTheBeamOnSpringsMeetTheClosedForm) {
  const ElasticSupport start{shifting, turning, 0.003}, end{2.0 * shifting, 0.5 * turning, 0.001};
  for (const double f : {5.0, 20.0, 60.0, 110.0}) {
    const Forces exact = closed_form(start, end, f, 0.02);
    const Forces fem = solved(wire(start, end), f);
    // 60 elements: (b h)^4/1440 below 1e-6 at 110 Hz, times the sharpness of the resonances, 50.
    EXPECT_LT(std::abs(fem.far - exact.far), 3e-5 * std::abs(exact.far)) << f;
    EXPECT_LT(std::abs(fem.near - exact.near), 3e-5 * std::abs(exact.near)) << f;
  }
}

TEST(ElasticSupport, StiffSpringsTendToTheClampInInverseProportion) {
  const double clamped = frequency(testing::straight_wire(), 2);
  for (const bool rotation : {true, false}) {
    const auto missing = [&](double factor) {
      ElasticSupport support;
      (rotation ? support.rotation : support.translation) = factor * (rotation ? turning : shifting);
      return clamped / frequency(wire(support, support), 2) - 1.0;
    };
    // Quadratic terms of a hundredth of the first at 100 times the reference stiffness.
    EXPECT_NEAR(missing(100.0) / missing(1000.0), 10.0, 0.5) << rotation;
    EXPECT_GT(missing(100.0), 1e-5) << rotation;
  }
}

TEST(ElasticSupport, WeakTurningSpringsTendToThePinInProportion) {
  Body pinned = testing::straight_wire();
  pinned.start = pinned.end = EndCondition::pinned;
  // A pinned straight wire turns about itself: its rigid motion comes first.
  const double pin = frequency(pinned, 1);
  const auto excess = [&](double rotation) {
    ElasticSupport support;
    support.rotation = rotation;
    const Body body = wire(support, support);
    const Eigen::VectorXd f =
        natural_frequencies_hz(body, solve_eigenmodes(assemble(body, 40), 6).eigenvalue);
    // The twist's mode on its spring lies anywhere; the bending one is the nearest to the pin's.
    return (f.array() / pin - 1.0).abs().minCoeff();
  };
  EXPECT_NEAR(excess(1e-2 * turning) / excess(1e-3 * turning), 10.0, 0.8);
  EXPECT_LT(excess(1e-4 * turning), 1e-3);
}

TEST(ElasticSupport, WeakShiftingSpringsCarryARigidBody) {
  ElasticSupport support;
  support.translation = 1e-3 * shifting;
  support.mass = 0.01;
  const Body body = wire(support, support);
  const double mass = mass_per_length * length + 0.02;
  const double rigid = std::sqrt(2.0 * support.translation / mass) / (2.0 * std::numbers::pi);
  // The wire bends by 1e-3 of the reference's 3000/EI L^-3 against its own 500: 0.1 %.
  EXPECT_NEAR(frequency(body, 0), rigid, 5e-3 * rigid);
}

TEST(ElasticSupport, ATurningComplianceLowersAllClampedModesAlike) {
  // d ln lambda = -4 EI/(k L) per end in every mode: phi''(0)^2 = 4 b^4 of a clamped end. The modulus does no
  // other, hence the inseparability (docs/supports.md).
  const double compliance = 1e-5;
  ElasticSupport support;
  support.rotation = bending / (compliance * length);
  for (const int mode : {0, 2, 4, 8}) {
    const double shift =
        2.0 * std::log(frequency(wire(support, {}), mode) / frequency(testing::straight_wire(), mode));
    EXPECT_NEAR(shift / compliance, -4.0, 0.02) << mode;  // 8 b L compliance of the fifth mode pair; mesh
  }
}

TEST(ElasticSupport, ModalConstantsAreTheResidueOfTheResponse) {
  Body body = testing::spline_wire();
  body.start_support = {shifting, turning, 0.002};
  body.end_support = {3.0 * shifting, turning, 0.001};
  body.material.loss_factor = constant_law(1e-5);
  const Model model = assemble(body, 24);
  const SupportMotion drive{{End::start}, Eigen::Vector3d::UnitY()};
  const Measurement measurement{SupportForce{End::end}, {Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}};
  const Eigenmodes modes = solve_eigenmodes(model, 4);
  const Eigen::MatrixXd constants =
      modal_constants(model, modes, drive, measurement, body.material.youngs_modulus);
  for (int r = 0; r < 4; ++r) {
    const double f = natural_frequency_hz(modes.eigenvalue[r], body.material.youngs_modulus);
    const double omega2 = std::pow(2.0 * std::numbers::pi * f, 2);
    const auto response =
        harmonic_response(model, drive, measurement, Eigen::VectorXd::Constant(1, f)).response;
    // At resonance the apparent mass is C (1 + i eta)/(i eta omega^2); the rest is 1e-5 of it, some 1e-3 of a
    // weak one.
    const Eigen::VectorXcd apparent = -response.row(0).transpose() / omega2;
    const Eigen::VectorXcd peak =
        constants.row(r).transpose() * (Complex(1.0, 1e-5) / Complex(0.0, 1e-5 * omega2));
    EXPECT_LT((apparent - peak).norm(), 2e-3 * peak.norm()) << r;
  }
}

TEST(ElasticSupport, AMovedBaseCarriesTheRestAlong) {
  Body body = testing::spline_wire();
  body.start_support = {shifting, turning, 0.002};
  body.end_support = {shifting, turning, 0.0};
  const Model model = assemble(body, 12);
  EXPECT_EQ(model.dof_count(), 6 * 15);
  const Eigenmodes modes = solve_eigenmodes(model);
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::VectorXd both = static_shape(model, modes, {End::start, End::end}, y);
  for (int node = -1; node <= 13; ++node) EXPECT_LT((both.segment<3>(model.node_dof(node)) - y).norm(), 1e-8);
  const Eigen::VectorXd one = static_shape(model, modes, {End::start}, y);
  const Eigen::VectorXd force = multiply(model.stiffness, one);
  // No force but at the bases, and those in balance.
  EXPECT_LT(Eigen::VectorXd(force(model.free_dof)).norm(), 1e-6 * force.norm());
  EXPECT_NEAR(force[1] + force[first_dof(model, End::end) + 1], 0.0, 1e-6 * std::abs(force[1]));
}

TEST(ElasticSupport, RefusesWhatNoSupportIs) {
  const auto refused = [](auto change) {
    Body body = testing::straight_wire();
    change(body);
    try {
      assemble(body, 4);
    } catch (const Error&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused([](Body& b) { b.start_support = {1e4, 10.0, 0.01}; }));
  EXPECT_TRUE(refused([](Body& b) { b.start_support.translation = 0.0; }));
  EXPECT_TRUE(refused([](Body& b) { b.end_support.rotation = -1.0; }));
  EXPECT_TRUE(refused([](Body& b) { b.end_support.mass = -1e-3; }));
  EXPECT_TRUE(refused([](Body& b) { b.end_support.rotation = std::nan(""); }));
  EXPECT_TRUE(refused([](Body& b) {
    b.start = EndCondition::pinned;
    b.start_support.rotation = 10.0;
  }));
  EXPECT_TRUE(refused([](Body& b) {
    b.end = EndCondition::free;
    b.end_support.translation = 1e4;
  }));
  EXPECT_TRUE(refused([](Body& b) {  // the stiffness is stated at the body's modulus
    b.material.youngs_modulus = {};
    b.start_support.rotation = 10.0;
  }));
}

}  // namespace
}  // namespace struna::fem
