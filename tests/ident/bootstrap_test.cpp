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

std::vector<SimulatedMode> modes_at(double factor) {
  std::vector<SimulatedMode> modes;
  for (const auto& [f, eta, a, b] : {std::array{40.0, 0.03, 1.0, 0.5}, std::array{90.0, 0.02, 0.8, -0.9}})
    modes.push_back({{f * factor, eta}, {a, b}});
  return modes;
}

BootstrapScatter scatter_of(const Record& record, long replicates) {
  const TransferEstimate estimate = estimate_transfer(record, "force", outputs, {});
  ModeOptions options;
  options.band_lo_hz = 20.0;
  options.band_hi_hz = 150.0;
  const ModeSet nominal = identify_modes(estimate.function, options);
  EXPECT_EQ(nominal.modes.size(), 2u);
  const WildRecords source({record}, "force", outputs, estimate, false);
  EXPECT_EQ(source.blocks(), 40);
  EstimateOptions same;
  same.method = estimate.method;
  std::mt19937_64 random(1);
  std::vector<ModeSet> sets;
  for (long n = 0; n < replicates; ++n)
    sets.push_back(
        identify_modes(estimate_transfer(source.draw(random), "force", outputs, same).function, options));
  return bootstrap_scatter(nominal, sets, source.blocks());
}

TEST(Bootstrap, AgreesWithTheStatedErrorsWhereNoiseIsSteady) {
  double frequency = 0.0, loss_factor = 0.0;
  constexpr unsigned seeds = 4;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const BootstrapScatter scatter = scatter_of(record_of(modes_at(1.0), 40.0, 512.0, 0.05, seed), 40);
    frequency += std::pow(scatter.frequency_ratio, 2.0) / seeds;
    loss_factor += std::pow(scatter.loss_factor_ratio, 2.0) / seeds;
    for (const ModeScatter& mode : scatter.modes) EXPECT_FALSE(mode.doubtful) << "seed " << seed;
  }
  // A ratio scatters by ratio_sigma = 0.16; the mean of 4 x 2 by 0.06. Three times that.
  EXPECT_NEAR(std::sqrt(frequency), 1.0, 0.2);
  EXPECT_NEAR(std::sqrt(loss_factor), 1.0, 0.2);
}

// A structure that softens by a tenth of a half-power band over the record: what stated errors take for noise
// is the same for blocks that follow each other.
TEST(Bootstrap, ExceedsTheStatedErrorsWhereTheStructureDrifts) {
  const Record before = record_of(modes_at(1.0), 40.0, 512.0, 0.001, 1),
               after = record_of(modes_at(0.99), 40.0, 512.0, 0.001, 1);
  Record drifting = before;
  for (long i = 0; i < drifting.samples.rows(); ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(drifting.samples.rows());
    drifting.samples.row(i) = (1.0 - t) * before.samples.row(i) + t * after.samples.row(i);
  }
  const BootstrapScatter scatter = scatter_of(drifting, 40);
  EXPECT_GT(scatter.frequency_ratio, 1.6);
  EXPECT_TRUE(scatter.modes[0].doubtful || scatter.modes[1].doubtful);
}

TEST(Bootstrap, RefusesWhatCannotTellAScatter) {
  EXPECT_THAT(tests::message_of([] { bootstrap_scatter({}, std::vector<ModeSet>(9), 40); }),
              HasSubstr("at least 10 replicates are needed, got 9"));
  const Record hit = record_of(modes_at(1.0), 4.0, 512.0, 0.01, 1);
  TransferEstimate estimate = estimate_transfer(hit, "force", outputs, {});
  EXPECT_THAT(tests::message_of([&] {
                WildRecords({hit, hit, hit, hit}, "force", outputs, estimate, true);
              }),
              HasSubstr("at least 5 blocks (hits) are needed, got 4"));
}

TEST(WildRecords, KeepInputAndWhatTheFunctionMakes) {
  const Record record = record_of(modes_at(1.0), 20.0, 512.0, 0.0, 1);
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
