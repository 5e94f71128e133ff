#include "ident/bootstrap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "ident/mode_identification.hpp"
#include "ident/wild_records.hpp"
#include "simulated_records.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using namespace simulated;
using ::testing::HasSubstr;

const std::vector<std::string> outputs = {"acceleration_x", "acceleration_y"};

std::vector<SimulatedMode> two_modes(double factor = 1.0) {
  std::vector<SimulatedMode> modes;
  for (const auto& [f, eta, a, b] : {std::array{40.0, 0.03, 1.0, 0.5}, std::array{90.0, 0.02, 0.8, -0.9}})
    modes.push_back({{f * factor, eta}, {a, b}});
  return modes;
}

BootstrapScatter scatter_of(const std::vector<Record>& records, long replicates, long blocks) {
  EstimateOptions local;
  local.method = EstimateMethod::local_rational;
  const TransferEstimate estimate = estimate_transfer(records, "force", outputs, local);
  ModeOptions options;
  options.band_lo_hz = 20.0;
  options.band_hi_hz = 150.0;
  const ModeSet nominal = identify_modes(estimate.function, options);
  EXPECT_EQ(nominal.modes.size(), 2u);
  const WildRecords source(records, "force", outputs, estimate, false);
  EXPECT_EQ(source.blocks(), blocks);
  std::mt19937_64 random(1);
  std::vector<ModeSet> sets;
  for (long n = 0; n < replicates; ++n)
    sets.push_back(
        identify_modes(estimate_transfer(source.draw(random), "force", outputs, local).function, options));
  return bootstrap_scatter(nominal, sets, source.blocks());
}

TEST(Bootstrap, AgreesWithTheStatedErrorsWhereNoiseIsSteady) {
  double frequency = 0.0, loss_factor = 0.0;
  constexpr unsigned seeds = 4;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const BootstrapScatter scatter = scatter_of({record_of(two_modes(), 40.0, 512.0, 0.05, seed)}, 40, 40);
    frequency += std::pow(scatter.frequency_ratio, 2.0) / seeds;
    loss_factor += std::pow(scatter.loss_factor_ratio, 2.0) / seeds;
    for (const ModeScatter& mode : scatter.modes) EXPECT_FALSE(mode.doubtful) << "seed " << seed;
  }
  // A ratio scatters by ratio_sigma = 0.16; the mean of 4 x 2 by 0.06. Three times that.
  EXPECT_NEAR(std::sqrt(frequency), 1.0, 0.2);
  EXPECT_NEAR(std::sqrt(loss_factor), 1.0, 0.2);
}

// A wire that is clamped anew for each of eight records: its frequencies move by 0.2 %, a tenth of a
// half-power band, each time. Within the records nothing tells that from noise, of which there would be some
// 200 independent values in a half-power band where there are eight.
TEST(Bootstrap, ExceedsTheStatedErrorsWhereTheSetUpChangesFromRecordToRecord) {
  std::vector<Record> records;
  unsigned seed = 0;
  for (const double moved : {1.0, -1.0, 0.5, -1.5, 1.2, -0.2, -0.8, 0.8})
    records.push_back(record_of(two_modes(1.0 + 0.002 * moved), 20.0, 512.0, 0.02, ++seed));
  const BootstrapScatter scatter = scatter_of(records, 40, 8);
  EXPECT_GT(scatter.frequency_ratio, 2.2);
  EXPECT_TRUE(scatter.modes[0].doubtful || scatter.modes[1].doubtful);
}

TEST(Bootstrap, RefusesWhatCannotTellAScatter) {
  EXPECT_THAT(tests::message_of([] { bootstrap_scatter({}, std::vector<ModeSet>(9), 40); }),
              HasSubstr("at least 10 replicates are needed, got 9"));
  const Record hit = record_of(two_modes(), 4.0, 512.0, 0.01, 1);
  TransferEstimate estimate = estimate_transfer(hit, "force", outputs, {});
  EXPECT_THAT(tests::message_of([&] {
                WildRecords({hit, hit, hit, hit}, "force", outputs, estimate, true);
              }),
              HasSubstr("at least 5 blocks (hits) are needed, got 4"));
}

TEST(WildRecords, KeepInputAndWhatTheFunctionMakes) {
  const Record record = record_of(two_modes(), 20.0, 512.0, 0.0, 1);
  const TransferEstimate estimate = estimate_transfer(record, "force", outputs, {});
  const WildRecords source({record}, "force", outputs, estimate, false);
  std::mt19937_64 random(1);
  const Record drawn = source.draw(random).front();
  const Eigen::VectorXd force = record.samples.col(0).array() - record.samples.col(0).mean();
  EXPECT_EQ(drawn.samples.col(0), force);
  // Without noise the rest is what leaks over the record's ends, and what interpolation leaves.
  const auto middle = [](const Record& r, long k) { return r.samples.col(k).segment(2048, 6144).eval(); };
  for (long k : {1L, 2L})
    EXPECT_LT((middle(drawn, k) - middle(record, k)).norm(), 0.03 * middle(record, k).norm());
}

TEST(WildRecords, FunctionBetweenLinesIsExactForOneResonanceBesideAConstant) {
  const auto h = [&](double f) {
    // One pole in f rather than f^2, so that the interpolant's form is the function's.
    return std::complex<double>(0.3, -0.1) + 1.0 / std::complex<double>((f - 100.0) / 1.0, 1.0);
  };
  Eigen::VectorXd lines = Eigen::VectorXd::LinSpaced(30, 80.0, 120.0), f(3);
  Eigen::VectorXcd value(30);
  for (long i = 0; i < 30; ++i) value(i) = h(lines(i));
  f << 99.1, 100.02, 104.7;
  const Eigen::VectorXcd between = between_lines(lines, value, f);
  for (long i = 0; i < 3; ++i) EXPECT_LT(std::abs(between(i) - h(f(i))), 1e-9) << f(i);
  // On a line its value, beyond the ends the end's.
  f << lines(7), 10.0, 500.0;
  const Eigen::VectorXcd at = between_lines(lines, value, f);
  EXPECT_EQ(at(0), value(7));
  EXPECT_EQ(at(1), value(0));
  EXPECT_EQ(at(2), value(29));
}

}  // namespace
}  // namespace struna::ident
