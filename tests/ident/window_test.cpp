#include "ident/window.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

TEST(Window, WordsReadBack) {
  for (const Window window : {Window::automatic, Window::hann, Window::rectangular, Window::exponential})
    EXPECT_EQ(window_kind(to_string(window)), window);
  EXPECT_THROW(window_kind("hamming"), Error);
}

TEST(Window, HannIsPeriodicWithItsKnownSums) {
  // Sum N/2, sum of squares 3N/8; rounding only.
  for (const long n : {16L, 17L, 1000L}) {
    const Eigen::VectorXd w = hann_window(n);
    EXPECT_NEAR(w.sum(), 0.5 * static_cast<double>(n), 1e-10);
    EXPECT_NEAR(w.squaredNorm(), 0.375 * static_cast<double>(n), 1e-10);
    EXPECT_EQ(w[0], 0.0);
    EXPECT_NEAR(w[1], w[n - 1], 1e-15);
  }
}

TEST(Window, ExponentialIsOneToTheHitAndThenDecays) {
  const Eigen::VectorXd w = exponential_window(100, 10, 5.0, 0.01);
  EXPECT_EQ(w.head(11).minCoeff(), 1.0);
  EXPECT_NEAR(w[60], std::exp(-5.0 * 0.5), 1e-15);
}

TEST(Window, EffectiveAveragesFollowWelch) {
  // Hann at half overlap: neighbours correlate by (1/6)^2 in power. Welch (1967): K/(1 + 2 (K - 1)/K/36).
  const Eigen::VectorXd hann = hann_window(1200);
  EXPECT_NEAR(effective_averages(hann, 14, 600), 14.0 / (1.0 + 2.0 * 13.0 / 14.0 / 36.0), 1e-9);
  // Rectangular at half overlap: rho = 1/2 in amplitude, 1/4 in power.
  EXPECT_NEAR(effective_averages(Eigen::VectorXd::Ones(100), 2, 50), 2.0 / (1.0 + 0.25), 1e-12);
  EXPECT_EQ(effective_averages(hann, 5, 1200), 5.0);
  EXPECT_EQ(effective_averages(hann, 1, 400), 1.0);
  // The same record, 7.5 segments long: a smaller hop never loses information and gains little beyond 2/3.
  const double half = effective_averages(hann, 14, 600);
  const double two_thirds = effective_averages(hann, 20, 400);
  const double three_quarters = effective_averages(hann, 27, 300);
  EXPECT_GT(two_thirds, 1.05 * half);
  EXPECT_NEAR(three_quarters / two_thirds, 1.0, 0.03);
}

TEST(Window, SmoothLengthIsTheNextOneBelowWithoutLargePrimes) {
  EXPECT_EQ(smooth_length(10240), 10240);
  EXPECT_EQ(smooth_length(10007), 10000);  // prime
  EXPECT_EQ(smooth_length(22), 21);
  EXPECT_EQ(smooth_length(1), 1);
}

}  // namespace
}  // namespace struna::ident
