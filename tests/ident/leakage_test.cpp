// How a Hann window widens resonances, and how that is taken out again.
#include "ident/leakage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "ident/mode_identification.hpp"

namespace struna::ident {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double frequency_hz = 100.0;
constexpr double loss_factor = 0.02;
constexpr double bandwidth_hz = frequency_hz * loss_factor;

/// Autocorrelation of a Hann window over its value at 0, u = lag over its length (docs/transfer_function.md).
double hann_correlation(double u) {
  return (1.0 - u) * (2.0 + std::cos(2.0 * pi * u)) / 3.0 + std::sin(2.0 * pi * u) / (2.0 * pi);
}

/// The accelerance-like circle 1/(x + i) of one mode as rough excitation and Hann segments of 1/line_hz show
/// it: the impulse response times the window's autocorrelation, transformed again.
std::complex<double> seen(double f_hz, double line_hz) {
  constexpr int steps = 4000;
  const std::complex<double> s(pi * bandwidth_hz, 2.0 * pi * (f_hz - frequency_hz));
  std::complex<double> sum = 0.0;
  for (int i = 0; i < steps; ++i) {  // midpoints
    const double u = (i + 0.5) / steps;
    sum += hann_correlation(u) * std::exp(-s * (u / line_hz));
  }
  return sum * (pi * bandwidth_hz / (steps * line_hz));
}

TransferFunction seen_through(double line_hz) {
  TransferFunction tf;
  const long lines = std::lround(40.0 * bandwidth_hz / line_hz);
  tf.frequency_hz = frequency_hz - 20.0 * bandwidth_hz +
                    line_hz * Eigen::ArrayXd::LinSpaced(lines, 0.0, static_cast<double>(lines - 1));
  tf.leakage_hz = line_hz;
  TransferFunction::Output output{"motion", FrfKind::receptance, "m/N", {}, {}, {}};
  output.value =
      tf.frequency_hz.unaryExpr([&](double f) { return std::complex<double>(0.0, -1.0) * seen(f, line_hz); });
  output.sigma = Eigen::VectorXd::Constant(lines, 0.02);
  tf.outputs.push_back(output);
  return tf;
}

TEST(Leakage, TheTrueBandwidthFollowsFromTheSeenOne) {
  for (const double n : {1.5, 3.0, 10.0}) {
    const double widening = leakage_share / (n * n);
    EXPECT_NEAR(leakage_widening(0.3 * n * (1.0 + widening), 0.3), widening, 1e-12);
  }
  EXPECT_EQ(leakage_widening(1.67, 1.0), 1.0);  // narrower than any is seen: 2 sqrt(0.7)
  EXPECT_EQ(leakage_widening(2.0, 0.0), 0.0);
  EXPECT_EQ(leakage_widening(2.0, NAN), 0.0);
}

TEST(Leakage, LowersAPeakAsMuchAsTheWindowDoes) {
  for (const double n : {1.0, 2.0, 4.0, 8.0, 16.0}) {
    const double peak = std::abs(seen(frequency_hz, bandwidth_hz / n));  // 1 without a window
    const double widening = leakage_share / (n * n);
    EXPECT_NEAR(leakage_lowering(n * (1.0 + widening), 1.0), 1.0 - peak, 0.04 / n) << n;
  }
  EXPECT_EQ(leakage_lowering(2.0, 0.0), 0.0);
}

TEST(Leakage, IsTakenOutOfAModeWithinWhatIsStated) {
  for (const double lines : {2.5, 4.0, 6.0, 10.0}) {
    TransferFunction tf = seen_through(bandwidth_hz / lines);
    const ModeSet set = identify_modes(tf);
    ASSERT_EQ(set.modes.size(), 1u) << lines;
    const Mode& mode = set.modes.front();
    tf.leakage_hz = NAN;
    const double raw = identify_modes(tf).modes.front().loss_factor / loss_factor - 1.0;
    EXPECT_GT(raw * lines * lines, 1.2) << lines;  // even weights: 4/3 to first order
    EXPECT_LT(raw * lines * lines, 1.6) << lines;
    EXPECT_LT(std::abs(mode.loss_factor / loss_factor - 1.0), 0.65 * raw) << lines;
    EXPECT_LT(std::abs(mode.loss_factor - loss_factor), 2.0 * mode.loss_factor_sigma) << lines;
    EXPECT_EQ(mode.has(ModeFlag::coarse), lines < 2.9) << lines;
    EXPECT_DOUBLE_EQ(mode.damping_ratio, 0.5 * mode.loss_factor);
  }
}

TEST(Leakage, AnEstimatorThatDoesNotLeakIsTakenAsItIs) {
  TransferFunction tf = seen_through(bandwidth_hz / 3.0);
  tf.leakage_hz = 0.0;
  const Mode mode = identify_modes(tf).modes.front();
  EXPECT_FALSE(mode.has(ModeFlag::coarse));
  tf.leakage_hz = NAN;
  const Mode unknown = identify_modes(tf).modes.front();
  EXPECT_TRUE(unknown.has(ModeFlag::coarse));  // below four lines
  EXPECT_EQ(mode.loss_factor, unknown.loss_factor);
}

}  // namespace
}  // namespace struna::ident
