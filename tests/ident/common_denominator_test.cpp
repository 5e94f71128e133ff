#include "ident/common_denominator.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "simulated_modes.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using fem::Damping;
using simulated::add_noise;
using simulated::function_of;
using simulated::lines;
using simulated::SimulatedMode;

// Three modes, the upper two half a bandwidth apart, of circles about one in radius.
std::vector<SimulatedMode> close_modes(Damping damping) {
  std::vector<SimulatedMode> modes = {{{240.0, 0.03}, {{1.0, 0.0}, {0.4, 0.1}, {-0.7, 0.0}}},
                                      {{300.0, 0.02}, {{1.0, 0.2}, {-0.8, 0.0}, {0.5, 0.0}}},
                                      {{303.0, 0.021}, {{0.6, 0.0}, {1.0, 0.0}, {0.9, -0.3}}}};
  for (SimulatedMode& mode : modes)
    for (auto& constant : mode.constant) constant *= pole_scale(mode.pole, damping);
  return modes;
}

TransferFunction close_function(Damping damping) {
  TransferFunction tf = function_of(close_modes(damping), lines(200.0, 400.0, 0.5), FrfKind::receptance,
                                    damping, {0.3, {0.1, -0.2}, -0.5});
  for (auto& output : tf.outputs) output.sigma = Eigen::VectorXd::Constant(tf.lines(), 1e-6);
  return tf;
}

// Largest distance of a mode from a pole, in bandwidths of frequency and relative loss factor.
double distance(const std::vector<DenominatorPole>& poles, const std::vector<SimulatedMode>& modes) {
  double worst = 0.0;
  for (const SimulatedMode& mode : modes) {
    double nearest = 1e9;
    for (const DenominatorPole& found : poles)
      nearest =
          std::min(nearest, std::hypot((found.pole.natural_frequency_hz - mode.pole.natural_frequency_hz) /
                                           bandwidth_hz(mode.pole),
                                       found.pole.loss_factor / mode.pole.loss_factor - 1.0));
    worst = std::max(worst, nearest);
  }
  return worst;
}

// Rounding: normal equations have the square of the basis's condition number.
TEST(CommonDenominator, MeetsHystereticModesExactlyAtTheirNumber) {
  const auto modes = close_modes(Damping::structural);
  const auto orders = fit_common_denominator(close_function(Damping::structural), Damping::structural, 3);
  ASSERT_EQ(orders.size(), 3u);
  ASSERT_EQ(orders[2].size(), 3u);
  EXPECT_LT(distance(orders[2], modes), 1e-5);
  EXPECT_GT(distance(orders[1], modes), 0.05);  // two poles cannot
  for (std::size_t r = 0; r < 3; ++r)
    for (long k = 0; k < 3; ++k)
      EXPECT_LT(
          std::abs(orders[2][r].modal_constant(k) / modes[r].constant[static_cast<std::size_t>(k)] - 1.0),
          1e-3);
}

TEST(CommonDenominator, StaysExactAboveTheirNumber) {
  const auto orders = fit_common_denominator(close_function(Damping::structural), Damping::structural, 12);
  for (std::size_t n = 3; n <= 12; ++n)
    EXPECT_LT(distance(orders[n - 1], close_modes(Damping::structural)), 1e-4) << "order " << n;
}

// Mirror images at negative frequency are met by two further orders to what is left of them.
TEST(CommonDenominator, MeetsViscousModesTwoOrdersAboveTheirNumber) {
  const auto orders = fit_common_denominator(close_function(Damping::viscous), Damping::viscous, 8);
  for (std::size_t n = 5; n <= 8; ++n)
    EXPECT_LT(distance(orders[n - 1], close_modes(Damping::viscous)), 1e-3) << "order " << n;
}

// What noise asks for falls outside the circle. Of n roots at random half would be damped.
TEST(CommonDenominator, LeavesTheZerosOfNoiseOutside) {
  long damped = 0, all = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    TransferFunction tf = close_function(Damping::structural);
    for (auto& output : tf.outputs) output.value.setZero();
    add_noise(tf, {1.0, 1.0, 1.0}, seed);
    const auto orders = fit_common_denominator(tf, Damping::structural, 14);
    for (std::size_t n = 1; n <= orders.size(); ++n) {
      damped += static_cast<long>(orders[n - 1].size());
      all += static_cast<long>(n);
    }
  }
  EXPECT_LT(static_cast<double>(damped), 0.05 * static_cast<double>(all));
}

TEST(CommonDenominator, RefusesWhatItCannotUse) {
  const TransferFunction good = close_function(Damping::structural);
  const auto refused = [](const TransferFunction& tf, int order) {
    return tests::message_of([&] { fit_common_denominator(tf, Damping::structural, order); });
  };
  EXPECT_EQ(refused(good, 0), "fit_common_denominator: max_order 1 to 60, got 0");
  EXPECT_EQ(refused(good, 61), "fit_common_denominator: max_order 1 to 60, got 61");
  EXPECT_EQ(refused(restrict_band(good, 200.0, 205.0), 14),
            "fit_common_denominator: at least max_order + 3 = 17 lines, got 11");
  TransferFunction none = good;
  none.outputs.clear();
  EXPECT_EQ(refused(none, 4), "fit_common_denominator: at least one output, got none");
  TransferFunction unknown = good;
  unknown.outputs[1].sigma.resize(0);
  EXPECT_EQ(refused(unknown, 4), "fit_common_denominator: a positive sigma on every line of force_y");
}

}  // namespace
}  // namespace struna::ident
