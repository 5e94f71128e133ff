#include "ident/half_power.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "tests/ident/simulated_modes.hpp"

namespace struna::ident {
namespace {

Mode pick(double loss_factor, int count) {
  const Pole pole{100.0, loss_factor};
  const auto tf =
      simulated::function_of({{pole, {pole_scale(pole, fem::Damping::structural)}}},
                             Eigen::VectorXd::LinSpaced(count, 80.0, 120.0), FrfKind::apparent_mass);
  return fit_half_power(tf, 100.0, 80.0, 120.0, fem::Damping::structural);
}

TEST(HalfPower, ReadsALoneModeOffItsPeak) {
  const Mode mode = pick(0.02, 2001);
  // Interpolation between lines a hundredth of a bandwidth apart.
  EXPECT_NEAR(mode.natural_frequency_hz, 100.0, 1e-3);
  EXPECT_NEAR(mode.loss_factor, 0.02, 2e-5);
  EXPECT_NEAR(mode.damping_ratio, 0.01, 1e-5);
  EXPECT_LT(mode.lower_half_power_hz, mode.natural_frequency_hz);
  EXPECT_GT(mode.upper_half_power_hz, mode.natural_frequency_hz);
}

TEST(HalfPower, HasNoStandardErrors) {
  const Mode mode = pick(0.02, 401);
  EXPECT_TRUE(std::isnan(mode.natural_frequency_sigma));
  EXPECT_TRUE(std::isnan(mode.loss_factor_sigma));
}

TEST(HalfPower, ConvergesWithTheLineSpacing) {
  const double coarse = std::abs(pick(0.02, 201).loss_factor / 0.02 - 1.0);  // ten lines per bandwidth
  const double fine = std::abs(pick(0.02, 2001).loss_factor / 0.02 - 1.0);
  EXPECT_LT(coarse, 0.02);
  EXPECT_LT(fine, 0.3 * coarse);
}

}  // namespace
}  // namespace struna::ident
