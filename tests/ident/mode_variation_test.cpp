#include "ident/mode_variation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "fem/error.hpp"
#include "ident/csv.hpp"
#include "tests/folder.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using ::testing::HasSubstr;
using tests::message_of;

Mode mode_at(double f_hz, double loss_factor = 0.01, double f_sigma = 0.01, double loss_sigma = 1e-4) {
  Mode mode;
  mode.natural_frequency_hz = f_hz;
  mode.natural_frequency_sigma = f_sigma;
  mode.loss_factor = loss_factor;
  mode.loss_factor_sigma = loss_sigma;
  mode.damping_ratio = 0.5 * loss_factor;
  return mode;
}

ModeSet set_of(std::vector<Mode> modes, fem::Damping damping = fem::Damping::structural) {
  ModeSet set;
  set.damping = damping;
  set.modes = std::move(modes);
  return set;
}

TEST(Variation, OfTwoValuesIsTheirDifferenceLessTheErrors) {
  // Two values d apart with errors s each: chi^2 = d^2/(2 s^2), between^2 = d^2/2 - s^2.
  const double d = 0.05, s = 0.01;
  const Variation v = variation_of(Eigen::Vector2d(700.0, 700.0 + d), Eigen::Vector2d(s, s));
  EXPECT_NEAR(v.mean, 700.0 + d / 2.0, 1e-12);
  EXPECT_NEAR(v.largest, d, 1e-12);
  EXPECT_NEAR(v.between, std::sqrt(d * d / 2.0 - s * s), 1e-9);
  EXPECT_NEAR(v.mean_sigma, std::sqrt((s * s + v.between * v.between) / 2.0), 1e-9);
  EXPECT_NEAR(v.probability, std::erfc(d / (2.0 * s)), 1e-9);  // of a normal's square, one degree of freedom
  EXPECT_TRUE(v.exceeds_errors());
}

TEST(Variation, OfOneValueIsItsError) {
  const Variation v = variation_of(Eigen::VectorXd::Constant(1, 0.3), Eigen::VectorXd::Constant(1, 0.02));
  EXPECT_DOUBLE_EQ(v.mean, 0.3);
  EXPECT_DOUBLE_EQ(v.mean_sigma, 0.02);
  EXPECT_EQ(v.between, 0.0);
  EXPECT_FALSE(v.exceeds_errors());
}

TEST(Variation, IsToldInFivePercentWhereThereIsNoneAndFoundWhereThereIs) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const int runs = 2000, sets = 6;
  const auto draw = [&](double between) {
    Eigen::VectorXd value(sets), sigma(sets);
    for (int k = 0; k < sets; ++k) {
      sigma[k] = 0.5 + 0.25 * k;
      value[k] = 100.0 + between * normal(random) + sigma[k] * normal(random);
    }
    return variation_of(value, sigma);
  };
  int told = 0, held = 0;
  double square = 0.0;
  for (int run = 0; run < runs; ++run) {
    told += draw(0.0).exceeds_errors() ? 1 : 0;
    const Variation v = draw(3.0);
    square += v.between * v.between;
    held += std::abs(v.mean - 100.0) < 2.57 * v.mean_sigma ? 1 : 0;  // t, 5 degrees of freedom, 95 %
  }
  EXPECT_NEAR(told / double(runs), 0.05, 3.0 * std::sqrt(0.05 * 0.95 / runs));
  EXPECT_NEAR(square / runs, 9.0, 0.6);  // unbiased; six values scatter it by 6/sqrt(2000)
  EXPECT_NEAR(held / double(runs), 0.95, 0.02);
}

TEST(ModeVariation, PairsModesThatAreNearestAndKeepsThoseThatAreAlone) {
  const auto modes = mode_variation({set_of({mode_at(100.0), mode_at(104.0), mode_at(300.0)}),
                                     set_of({mode_at(100.02), mode_at(103.9), mode_at(200.0)}),
                                     set_of({mode_at(99.99), mode_at(300.1)})});
  ASSERT_EQ(modes.size(), 4u);
  EXPECT_EQ(modes[0].place, (std::vector<long>{0, 0, 0}));
  EXPECT_EQ(modes[1].place, (std::vector<long>{1, 1, -1}));
  EXPECT_EQ(modes[2].place, (std::vector<long>{-1, 2, -1}));
  EXPECT_EQ(modes[3].place, (std::vector<long>{2, -1, 1}));
  EXPECT_FALSE(modes[0].frequency.exceeds_errors());
  EXPECT_TRUE(modes[1].frequency.exceeds_errors());
  EXPECT_FALSE(modes[1].damping.exceeds_errors());
  EXPECT_EQ(modes[2].sets(), 1);
}

TEST(ModeVariation, OneModeIsPairedWithTheNearerOfTwo) {
  const auto modes = mode_variation({set_of({mode_at(100.0)}), set_of({mode_at(100.1), mode_at(100.6)})});
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_EQ(modes[0].place, (std::vector<long>{0, 0}));
  EXPECT_EQ(modes[1].place, (std::vector<long>{-1, 1}));
}

TEST(ModeVariation, ViscousSetsTellTheDampingRatio) {
  const auto modes = mode_variation(
      {set_of({mode_at(100.0)}, fem::Damping::viscous), set_of({mode_at(100.0)}, fem::Damping::viscous)});
  EXPECT_NEAR(modes[0].damping.mean, 0.005, 1e-15);
  EXPECT_NEAR(modes[0].damping.mean_sigma, 0.5e-4 / std::sqrt(2.0), 1e-15);
}

TEST(ModeVariation, IsWrittenWithItsUnits) {
  const tests::Folder folder;
  ModeSet flagged = set_of({mode_at(100.0)});
  flagged.modes[0].flags = {ModeFlag::noisy, ModeFlag::coarse};
  const auto modes = mode_variation({flagged, set_of({mode_at(100.1)})});
  const std::string file = (folder / "variation.csv").string();
  write_mode_variation(modes, fem::Damping::structural, file);
  CsvReader csv(file);
  std::vector<std::string_view> fields;
  ASSERT_TRUE(csv.next(fields));
  EXPECT_NEAR(csv.number(fields, csv.column("natural_frequency")), 100.05, 1e-9);
  EXPECT_EQ(csv.header()[0].unit, "Hz");
  EXPECT_EQ(csv.number(fields, csv.column("sets")), 2.0);
  EXPECT_EQ(fields.back(), "noisy;coarse");
  EXPECT_FALSE(csv.next(fields));
}

TEST(ModeVariation, RefusesWhatCannotBeCompared) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const ModeSet good = set_of({mode_at(100.0)});
  EXPECT_THAT(message_of([&] { mode_variation({good}); }), HasSubstr("at least two sets"));
  EXPECT_THAT(message_of([&] { mode_variation({good, set_of({})}); }), HasSubstr("set 2 has no modes"));
  EXPECT_THAT(message_of([&] {
                mode_variation({good, set_of({mode_at(100.0)}, fem::Damping::viscous)});
              }),
              HasSubstr("viscous damping"));
  EXPECT_THAT(message_of([&] {
                mode_variation({set_of({mode_at(100.0, 0.01, none)}), good});
              }),
              HasSubstr("set 1 has no standard errors at 100 Hz"));
  EXPECT_THROW(variation_of(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(0.1, 0.0)), Error);
}

}  // namespace
}  // namespace struna::ident
