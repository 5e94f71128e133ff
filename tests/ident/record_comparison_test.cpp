#include "ident/record_comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr double rate = 1000.0;

Record record_of(long count, const std::function<double(double)>& force) {
  Record record;
  record.sample_interval = 1.0 / rate;
  record.channels = {{"displacement", Quantity::displacement, 0.0}, {"force_y", Quantity::force, 0.0}};
  record.samples.resize(count, 2);
  for (long i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate;
    record.samples.row(i) << std::sin(t), force(t);
  }
  return record;
}

double tone(double t) {
  return 3.0 * std::sin(2.0 * std::numbers::pi * 50.0 * t);
}

TEST(HalfOctaveLevels, OfAToneIsItsRmsInItsBandAlone) {
  const auto comparison =
      compare_records(record_of(8000, tone), record_of(8000, tone), {1.0, 0.0, 20.0, 400.0});
  const auto& levels = comparison.signals.at(0).measured;
  ASSERT_EQ(levels.bands(), 8);  // 20, 28.3, 40, 56.6, … 320 (each 2^(k/2))
  // Hann's main lobe is four lines of 0.94 Hz wide: all of it lies within 40 to 56.6 Hz.
  EXPECT_NEAR(levels.rms[2], 3.0 / std::numbers::sqrt2, 1e-3);
  EXPECT_LT(levels.rms[6], 1e-3);
}

TEST(HalfOctaveLevels, OfAFlatDensityGrowWithTheBandwidth) {
  const Eigen::VectorXd frequency = Eigen::VectorXd::LinSpaced(401, 0.0, 400.0);
  const Eigen::VectorXd edge = half_octave_edges(20.0, 300.0);
  const auto levels = half_octave_levels(frequency, Eigen::VectorXd::Constant(401, 4.0), edge);
  for (long k = 0; k < levels.bands(); ++k)
    EXPECT_NEAR(levels.rms[k], 2.0 * std::sqrt(edge[k + 1] - edge[k]), 1e-12);  // rounding
}

TEST(HalfOctaveLevels, FromTwentyToNineHundredHertzAreElevenBands) {
  const Eigen::VectorXd edge = half_octave_edges(20.0, 900.0);
  ASSERT_EQ(edge.size(), 12);
  EXPECT_NEAR(edge[11], 905.097, 1e-3);
}

TEST(CompareRecords, FindsTheFactorBetweenTwoRecordsAsALevel) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  std::vector<double> noise(6000);
  for (double& value : noise) value = normal(generator);
  const auto at = [&](double t) { return noise[static_cast<std::size_t>(std::lround(t * rate))]; };
  const auto comparison =
      compare_records(record_of(6000, at), record_of(5900, [&](double t) { return 2.0 * at(t) + 7.0; }));
  const auto& signal = comparison.signals.at(0);
  ASSERT_EQ(signal.correlation.size(), 6);  // the last of 0.9 s
  for (const double r : signal.correlation) EXPECT_NEAR(r, 1.0, 1e-12);
  for (const double db : signal.level_db) EXPECT_NEAR(db, 20.0 * std::log10(2.0), 1e-9);
}

TEST(CompareRecords, TellsWhetherTheMotionsAreTheSame) {
  const auto simulated = record_of(6000, tone);
  EXPECT_NEAR(compare_records(simulated, simulated).motion_correlation, 1.0, 1e-12);
  auto foreign = simulated;
  for (long i = 0; i < 6000; ++i) foreign.samples(i, 0) = std::sin(1.7 * static_cast<double>(i) / rate);
  EXPECT_LT(std::abs(compare_records(foreign, simulated).motion_correlation), 0.9);
  foreign.channels[0].name = "motion";
  EXPECT_THROW(compare_records(foreign, simulated), Error);
}

TEST(CompareRecords, CorrelationFallsWithIndependentNoise) {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  const auto measured = record_of(20000, tone);
  const auto noisy = record_of(20000, [&](double t) { return tone(t) + 1.5 * normal(generator); });
  const auto signal = compare_records(measured, noisy).signals.at(0);
  // r = 1/sqrt(1 + var(noise)/var(tone)) = 1/sqrt(1 + 2.25/4.5); its deviation (1 - r^2)/sqrt(n) is 0.0024.
  EXPECT_NEAR(signal.correlation_of_all, 1.0 / std::sqrt(1.5), 0.008);
}

TEST(CompareRecords, LeavesOutWhatIsAtRest) {
  const auto comparison = compare_records(record_of(4000, tone), record_of(4000, [](double) { return 0.0; }));
  EXPECT_TRUE(comparison.signals.empty());
  EXPECT_EQ(comparison.not_compared, std::vector<std::string>{"force_y"});
}

TEST(CompareRecords, SkipsTheStartInTheLevelsButNotInTheCorrelations) {
  const auto measured = record_of(6000, tone);
  const auto late = record_of(6000, [](double t) { return t < 1.0 ? -tone(t) : tone(t); });
  const auto signal = compare_records(measured, late, {1.0, 1.0, 20.0, 400.0}).signals.at(0);
  EXPECT_NEAR(signal.correlation[0], -1.0, 1e-12);
  EXPECT_NEAR(signal.correlation_of_all, 1.0, 1e-12);
}

TEST(CompareRecords, RefusesWhatCannotBeCompared) {
  const auto good = record_of(4000, tone);
  auto faster = good;
  faster.sample_interval *= 0.5;
  EXPECT_THROW(compare_records(good, faster), Error);
  EXPECT_THROW(compare_records(good, record_of(900, tone)), Error);
  EXPECT_THROW(compare_records(good, good, {0.0, 0.0, 20.0, 400.0}), Error);
  EXPECT_THROW(compare_records(good, good, {1.0, -1.0, 20.0, 400.0}), Error);
  EXPECT_THROW(compare_records(good, good, {1.0, 3.5, 20.0, 400.0}), Error);
  EXPECT_THROW(half_octave_edges(0.0, 100.0), Error);
  EXPECT_THROW(half_octave_edges(90.0, 100.0), Error);
  EXPECT_THROW(
      half_octave_levels(Eigen::VectorXd::Ones(1), Eigen::VectorXd::Ones(1), half_octave_edges(20.0, 100.0)),
      Error);
}

}  // namespace
}  // namespace struna::ident
