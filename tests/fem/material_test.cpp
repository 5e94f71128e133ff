#include "fem/material.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Kind = FrequencyLaw::Kind;

FrequencyLaw closed_form(Kind kind, std::vector<double> parameters) {
  return {kind, std::move(parameters), {}, {}, 0.0, 0.0};
}
FrequencyLaw knots(Kind kind, std::vector<double> frequency, std::vector<double> value) {
  return {kind, {}, std::move(frequency), std::move(value), 0.0, 0.0};
}

std::vector<FrequencyLaw> one_of_each() {
  return {constant_law(1e11), closed_form(Kind::power, {1e11, 0.02, 100.0}),
          closed_form(Kind::fractional_zener, {9e10, 1.4, 300.0, 0.6}),
          knots(Kind::monotone_spline, {10, 40, 60, 300, 1000}, {1.0, 1.1, 1.5, 1.55, 1.6}),
          knots(Kind::table, {10, 40, 60, 300, 1000}, {1.0, 1.1, 0.9, 1.55, 1.6})};
}

TEST(FrequencyLaw, ClosedFormsAreTheirFormulas) {
  EXPECT_EQ(constant_law(3.0).at(17.0), 3.0);
  // Rounding of pow: a few units in the last place.
  EXPECT_NEAR(closed_form(Kind::power, {2.0, 0.5, 10.0}).at(40.0), 4.0, 1e-15);
  const FrequencyLaw zener = closed_form(Kind::fractional_zener, {2.0, 3.0, 50.0, 0.4});
  for (double f : {1.0, 49.0, 50.0, 1e4}) {
    const std::complex<double> z = std::pow(std::complex<double>(0.0, f / 50.0), 0.4);
    EXPECT_NEAR(zener.at(f), 2.0 * ((1.0 + 3.0 * z) / (1.0 + z)).real(), 1e-14);  // rounding
  }
}

TEST(FrequencyLaw, FractionalZenerRunsFromItsLowToItsHighLimit) {
  const FrequencyLaw rising = closed_form(Kind::fractional_zener, {2.0, 3.0, 50.0, 0.9});
  // The tails close as (f/f_relax)^-alpha: 1e-18 at twenty decades.
  EXPECT_NEAR(rising.at(50e-20), 2.0, 1e-14);
  EXPECT_NEAR(rising.at(50e20), 6.0, 1e-14);
  EXPECT_EQ(closed_form(Kind::fractional_zener, {2.0, 3.0, 1e-300, 1.0}).at(1e300), 6.0);  // overflow of r
  double before = 0.0;
  for (double f = 1e-3; f < 1e6; f *= 1.3) {
    EXPECT_GT(rising.at(f), before);
    before = rising.at(f);
  }
  EXPECT_LT(closed_form(Kind::fractional_zener, {2.0, 0.5, 50.0, 0.9}).at(1e6), 1.01);
}

TEST(FrequencyLaw, LogSlopeIsTheDerivative) {
  for (const FrequencyLaw& law : one_of_each()) {
    for (double f : {11.0, 33.0, 47.0, 100.0, 299.0, 700.0}) {
      const double h = 1e-5;  // central difference: h^2 discretisation 1e-10, rounding 1e-16/h = 1e-11
      const double difference = std::log(law.at(f * std::exp(h)) / law.at(f * std::exp(-h))) / (2.0 * h);
      EXPECT_NEAR(law.log_slope(f), difference, 2e-9) << to_string(law.kind) << " at " << f;
    }
  }
}

TEST(FrequencyLaw, KnotLawsPassThroughTheirKnotsAndHoldTheirEnds) {
  for (Kind kind : {Kind::monotone_spline, Kind::table}) {
    const FrequencyLaw law = knots(kind, {10, 40, 60, 300}, {1.0, 1.1, 1.5, 1.4});
    for (std::size_t k = 0; k < law.frequency.size(); ++k) {
      EXPECT_NEAR(law.at(law.frequency[k]), law.value[k], 1e-15);  // rounding
    }
    EXPECT_EQ(law.at(1.0), 1.0);
    EXPECT_EQ(law.at(5000.0), 1.4);
    EXPECT_EQ(law.log_slope(1.0), 0.0);
    EXPECT_EQ(law.log_slope(5000.0), 0.0);
  }
}

TEST(FrequencyLaw, TableIsLinearBetweenItsEntries) {
  const FrequencyLaw law = knots(Kind::table, {10, 20, 40}, {1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(law.at(15.0), 2.0);
  EXPECT_DOUBLE_EQ(law.at(30.0), 2.5);
  EXPECT_DOUBLE_EQ(knots(Kind::table, {10}, {2.0}).at(5.0), 2.0);
}

TEST(FrequencyLaw, MonotoneSplineNeverOvershootsItsKnots) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> step(0.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> frequency{10.0};
    std::vector<double> value{1.0};
    for (int k = 0; k < 7; ++k) {
      frequency.push_back(frequency.back() * (1.0 + 0.01 + step(random)));
      value.push_back(value.back() + std::pow(step(random), 6));  // mostly flat with jumps: the hard case
    }
    const FrequencyLaw law = knots(Kind::monotone_spline, frequency, value);
    double before = value.front();
    for (int i = 0; i <= 2000; ++i) {
      const double f = frequency.front() * std::pow(frequency.back() / frequency.front(), i / 2000.0);
      EXPECT_GE(law.at(f), before - 1e-14);  // rounding
      EXPECT_GE(law.log_slope(f), -1e-13);   // rounding of the cubic's derivative
      before = law.at(f);
    }
  }
}

TEST(FrequencyLaw, MonotoneSplineReproducesALineInLogFrequency) {
  std::vector<double> frequency, value;
  for (double f = 10.0; f < 2000.0; f *= 1.7) {
    frequency.push_back(f);
    value.push_back(1.0 + 0.3 * std::log(f));
  }
  const FrequencyLaw law = knots(Kind::monotone_spline, frequency, value);
  for (double f = 10.0; f < frequency.back(); f *= 1.1) {
    EXPECT_NEAR(law.at(f), 1.0 + 0.3 * std::log(f), 1e-14);  // rounding
  }
}

TEST(FrequencyLaw, MonotoneSplineConvergesOnASmoothCurveAtThirdOrderOrMore) {
  // Two-point end tangents and averaged secants are second-order tangents: the cubic is third order locally.
  const auto error = [](int intervals) {
    std::vector<double> frequency, value;
    for (int k = 0; k <= intervals; ++k) {
      frequency.push_back(10.0 * std::pow(100.0, static_cast<double>(k) / intervals));
      value.push_back(std::exp(0.5 * std::log(frequency.back())));
    }
    const FrequencyLaw law = knots(Kind::monotone_spline, frequency, value);
    double worst = 0.0;
    for (double f = 50.0; f < 200.0; f *= 1.001) worst = std::max(worst, std::abs(law.at(f) - std::sqrt(f)));
    return worst;
  };
  const double order = std::log2(error(20) / error(40));
  EXPECT_GT(order, 2.8);
  EXPECT_LT(order, 4.2);
}

TEST(FrequencyLaw, TellsWhenItExtrapolates) {
  FrequencyLaw law = constant_law(1.0);
  EXPECT_FALSE(law.extrapolates_at(1e9));
  law.valid_from_hz = 10.0;
  law.valid_to_hz = 100.0;
  EXPECT_TRUE(law.extrapolates_at(9.0));
  EXPECT_FALSE(law.extrapolates_at(10.0));
  EXPECT_TRUE(law.extrapolates_at(101.0));
}

TEST(FrequencyLaw, ZeroLossFactorIsAllowedWhereAskedFor) {
  EXPECT_NO_THROW(validate(constant_law(0.0), "loss_factor", true));
  EXPECT_THROW(validate(constant_law(0.0), "youngs_modulus"), Error);
  const FrequencyLaw zero_table = knots(Kind::table, {10, 20}, {0.0, 0.0});
  EXPECT_NO_THROW(validate(zero_table, "loss_factor", true));
  EXPECT_EQ(zero_table.log_slope(15.0), 0.0);
}

TEST(FrequencyLaw, RefusesWhatIsNoLaw) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FrequencyLaw backwards = constant_law(1.0);
  backwards.valid_from_hz = 100.0;
  backwards.valid_to_hz = 10.0;
  const std::vector<std::pair<FrequencyLaw, std::string>> cases = {
      {closed_form(Kind::constant, {}), "takes 1 parameter, got 0"},
      {closed_form(Kind::constant, {-1.0}), "value must be positive, got -1"},
      {closed_form(Kind::constant, {nan}), "value must be positive"},
      {closed_form(Kind::power, {1.0, 0.1}), "takes 3 parameters, got 2"},
      {closed_form(Kind::power, {1.0, nan, 10.0}), "exponent must be finite"},
      {closed_form(Kind::power, {1.0, 0.1, 0.0}), "reference_frequency [Hz] must be positive, got 0"},
      {closed_form(Kind::fractional_zener, {1.0, 0.0, 10.0, 0.5}), "ratio must be positive, got 0"},
      {closed_form(Kind::fractional_zener, {1.0, 2.0, -1.0, 0.5}),
       "relaxation_frequency [Hz] must be positive"},
      {closed_form(Kind::fractional_zener, {1.0, 2.0, 10.0, 0.0}), "order must be positive, got 0"},
      {closed_form(Kind::fractional_zener, {1.0, 2.0, 10.0, 1.5}), "order must be at most 1, got 1.5"},
      {knots(Kind::table, {}, {}), "1 or more entries, got 0"},
      {knots(Kind::monotone_spline, {10.0}, {1.0}), "2 or more entries, got 1"},
      {knots(Kind::table, {10.0, 20.0}, {1.0}), "equal length, got 2 and 1"},
      {knots(Kind::table, {20.0, 10.0}, {1.0, 1.0}), "frequency must increase, got 10 Hz after 20 Hz"},
      {knots(Kind::table, {0.0, 10.0}, {1.0, 1.0}), "frequency [Hz] must be positive, got 0"},
      {knots(Kind::table, {5.0, 10.0}, {1.0, 0.0}), "value must be positive, got 0"},
      {backwards, "valid range must run upwards"}};
  for (const auto& [law, rule] : cases) {
    try {
      validate(law, "wire: youngs_modulus");
      ADD_FAILURE() << "accepted: " << rule;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(rule), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).rfind("wire: youngs_modulus: ", 0), 0u) << error.what();
    }
  }
  for (const FrequencyLaw& law : one_of_each()) EXPECT_NO_THROW(validate(law, "law"));
}

TEST(FrequencyLaw, KindsRoundTripThroughTheirNames) {
  for (const FrequencyLaw& law : one_of_each()) EXPECT_EQ(law_kind(to_string(law.kind)), law.kind);
  EXPECT_THROW(law_kind("cubic"), Error);
  EXPECT_EQ(damping_kind(to_string(Damping::viscous)), Damping::viscous);
  EXPECT_EQ(damping_kind(to_string(Damping::structural)), Damping::structural);
  EXPECT_THROW(damping_kind("hysteretic"), Error);
}

TEST(Rayleigh, DampingRatioIsEquationTen) {
  const double omega = 2.0 * std::numbers::pi * 50.0;
  EXPECT_NEAR(rayleigh_damping_ratio({43.1, 2e-6}, 50.0), 0.5 * (43.1 / omega + 2e-6 * omega), 1e-17);
}

}  // namespace
}  // namespace struna::fem
