#include "ident/periodic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fem/error.hpp"
#include "ident/excitation.hpp"
#include "ident/window.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
using testing::HasSubstr;
constexpr double dt = 1e-3;

/// Multisine of the lines 3, 6, 9 ... 240 of a period with random phases, and its response to 2 - 0.5 i
/// omega/1000; `drift` exp(-t) starts with the response.
Eigen::MatrixXd multisine(long samples, long period, double noise, double drift, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::mt19937_64 phases(7);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  Eigen::MatrixXd record = Eigen::MatrixXd::Zero(samples, 2);
  for (long line = 3; line <= 240; line += 3) {
    const double omega =
        2.0 * std::numbers::pi * static_cast<double>(line) / (static_cast<double>(period) * dt);
    const Complex x = std::polar(1.0, phase(phases)), h(2.0, -0.0005 * omega);
    for (long n = 0; n < samples; ++n) {
      const Complex turn = std::polar(1.0, omega * static_cast<double>(n) * dt);
      record(n, 0) += (x * turn).real();
      record(n, 1) += (h * x * turn).real();
    }
  }
  for (long n = 0; n < samples; ++n) {
    record(n, 0) += noise * normal(random);
    record(n, 1) += noise * normal(random) + drift * std::exp(-static_cast<double>(n) * dt);
  }
  return record;
}

Complex truth(double f) {
  return {2.0, -0.0005 * 2.0 * std::numbers::pi * f};
}

long period_of(const Eigen::VectorXd& input) {
  Fft fft(smooth_length(input.size()));
  fft.input() = input.head(fft.length());
  const Eigen::VectorXcd transform = fft.transform();
  return find_period(input, transform, fft);
}

TEST(Excitation, APeriodIsFoundWhetherOrNotTheRecordHoldsWholeOnes) {
  for (const long samples : {2000L, 4000L, 4700L, 5500L})
    for (const double noise : {0.0, 0.5})  // 0.5 of 6.3 rms: 0.6 % of the power
      EXPECT_EQ(period_of(multisine(samples, 1000, noise, 0.0, 1).col(0)), 1000) << samples << " " << noise;
}

TEST(Excitation, NoiseAndSweepsHaveNoPeriod) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Eigen::VectorXd noise(4000), sweep(4000), narrow(4000);
  double before = 0.0, last = 0.0;
  for (long n = 0; n < 4000; ++n) {
    noise[n] = normal(random);
    const double t = static_cast<double>(n) / 4000.0;
    sweep[n] = std::sin(2.0 * std::numbers::pi * 300.0 * t * t);
    // a lightly damped resonance: nearly a sine for a while
    narrow[n] = 1.95 * last - 0.98 * before + normal(random);
    before = last;
    last = narrow[n];
  }
  EXPECT_EQ(period_of(noise), 0);
  EXPECT_EQ(period_of(sweep), 0);
  EXPECT_EQ(period_of(narrow), 0);
  EXPECT_TRUE(passes_over_lines(sweep));
  EXPECT_FALSE(passes_over_lines(noise));
  EXPECT_FALSE(passes_over_lines(narrow));
  EXPECT_FALSE(passes_over_lines(multisine(4000, 1000, 0.0, 0.0, 1).col(0)));
  EXPECT_FALSE(passes_over_lines(sweep.head(500)));  // too short to tell
}

TEST(Periodic, WithoutNoiseTheExcitedLinesAreExactAndNoOthersAreThere) {
  const PeriodicEstimate estimate = periodic_estimate({multisine(4300, 1000, 0.0, 0.0, 1)}, 1000, dt);
  EXPECT_EQ(estimate.periods, 4);
  ASSERT_EQ(estimate.frequency_hz.size(), 80);
  for (long i = 0; i < 80; ++i) {
    EXPECT_NEAR(estimate.frequency_hz[i], 3.0 * static_cast<double>(i + 1), 1e-9);
    EXPECT_LT(std::abs(estimate.value(i, 0) - truth(estimate.frequency_hz[i])), 1e-9);  // rounding
  }
}

// z over 80 lines x 2 parts x 20 seeds: its mean square scatters by 2.5 %; nine degrees of freedom behind
// sigma make it (18/16).
TEST(Periodic, ErrorsAreThoseThatTheScatterOverPeriodsTells) {
  double square = 0.0;
  long count = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const PeriodicEstimate estimate = periodic_estimate({multisine(10000, 1000, 0.3, 0.0, seed)}, 1000, dt);
    EXPECT_EQ(estimate.frequency_hz.size(), 80);
    for (long i = 0; i < estimate.frequency_hz.size(); ++i, ++count)
      square +=
          0.5 * std::norm((estimate.value(i, 0) - truth(estimate.frequency_hz[i])) / estimate.sigma(i, 0));
  }
  EXPECT_NEAR(square / static_cast<double>(count), 18.0 / 16.0, 0.12);
}

TEST(Periodic, SettlingPeriodsAreLeftOut) {
  const PeriodicEstimate settled = periodic_estimate({multisine(8000, 1000, 0.01, 5.0, 2)}, 1000, dt);
  EXPECT_GE(settled.settling, 3);
  EXPECT_EQ(settled.settling + settled.periods, 8);
  EXPECT_EQ(periodic_estimate({multisine(8000, 1000, 0.01, 0.0, 2)}, 1000, dt).settling, 0);
}

TEST(Periodic, WrongRecordsAreRefused) {
  const auto message = [](const std::vector<Eigen::MatrixXd>& records, long period) -> std::string {
    try {
      periodic_estimate(records, period, dt);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message({}, 1000), HasSubstr("needs a record"));
  EXPECT_THAT(message({multisine(2000, 1000, 0.0, 0.0, 1)}, 3), HasSubstr("at least 4 samples"));
  EXPECT_THAT(message({multisine(1999, 1000, 0.0, 0.0, 1)}, 1000), HasSubstr("fewer than two periods"));
}

}  // namespace
}  // namespace struna::ident
