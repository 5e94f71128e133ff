#include "ident/half_power.hpp"

#include <gtest/gtest.h>

#include "fem/error.hpp"
#include "simulated_modes.hpp"

namespace struna::ident {
namespace {

using fem::Damping;
using simulated::function_of;
using simulated::lines;

TEST(HalfPower, ResolvedModeIsReadWithinTheInterpolation) {
  for (const Damping damping : {Damping::structural, Damping::viscous}) {
    const FrfKind form = damping == Damping::structural ? FrfKind::receptance : FrfKind::mobility;
    const TransferFunction tf =
        function_of({{{100.0, 0.02}, {1.0, -0.4}}}, lines(90.0, 110.0, 0.05), form, damping);
    const Mode mode = fit_half_power(tf, 101.0, 90.0, 110.0, damping);
    // A twentieth of the bandwidth's half per line: linear interpolation errs by (1/20)^2 of it; the
    // conjugate pole adds zeta^2.
    EXPECT_NEAR(mode.natural_frequency_hz, 100.0, 0.012);
    EXPECT_NEAR(mode.loss_factor, 0.02, 5e-5);
    EXPECT_NEAR(mode.damping_ratio, 0.5 * mode.loss_factor, 1e-15);
    EXPECT_TRUE(std::isnan(mode.loss_factor_sigma));
    EXPECT_NEAR(std::abs(mode.modal_constant(1) / mode.modal_constant(0)), 0.4, 2e-3);
  }
}

TEST(HalfPower, ErrorFallsWithTheSquareOfTheLineSpacing) {
  const auto error = [](double step) {
    double sum = 0.0;  // over positions of the resonance between lines
    for (int i = 0; i < 8; ++i) {
      const Pole pole{100.0 + step * i / 8.0, 0.02};
      const TransferFunction tf = function_of({{pole, {1.0}}}, lines(90.0, 110.0, step), FrfKind::receptance);
      sum += std::abs(fit_half_power(tf, 100.0, 90.0, 110.0, Damping::structural).loss_factor - 0.02);
    }
    return sum;
  };
  const double order = std::log2(error(0.2) / error(0.1));
  EXPECT_GT(order, 1.6);
  EXPECT_LT(order, 2.6);
}

TEST(HalfPower, OneFlankStandsForBothWhereTheOtherIsCut) {
  const TransferFunction tf =
      function_of({{{100.0, 0.02}, {1.0}}}, lines(90.0, 110.0, 0.05), FrfKind::receptance);
  const Mode mode = fit_half_power(tf, 100.0, 99.5, 110.0, Damping::structural);
  EXPECT_NEAR(mode.loss_factor, 0.02, 3e-4);
}

TEST(HalfPower, NoFallToAHalfIsNotConverged) {
  const TransferFunction tf =
      function_of({{{100.0, 0.02}, {1.0}}}, lines(90.0, 110.0, 0.05), FrfKind::receptance);
  const Mode mode = fit_half_power(tf, 100.0, 99.7, 100.3, Damping::structural);
  EXPECT_TRUE(mode.has(ModeFlag::not_converged));
  EXPECT_EQ(mode.modal_constant.size(), 1);
  EXPECT_THROW(fit_half_power(tf, 100.0, 99.98, 100.06, Damping::structural), Error);
}

}  // namespace
}  // namespace struna::ident
