#include "ident/references.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ident/rank_one_fit.hpp"
#include "simulated_references.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using namespace simulated;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TransferFunction small_function(double step_hz = 1.0, double value = 1.0) {
  TransferFunction tf;
  tf.frequency_hz = lines(10.0, 20.0, step_hz);
  for (const char* name : {"force_y", "force_z"})
    tf.outputs.push_back(
        {name, FrfKind::dynamic_stiffness, "N/m", Eigen::VectorXcd::Constant(tf.lines(), value), {}, {}});
  return tf;
}

TEST(References, CombinedFunctionNamesOutputsByReferenceAndKeepsSharedLines) {
  TransferFunction other = small_function(1.0, 2.0);
  other = restrict_band(other, 13.0, 20.0);
  const TransferFunction all = combine_references({{"y", "y.csv", small_function()}, {"z", "z.csv", other}});
  EXPECT_THAT(output_names(all), ElementsAre("force_y", "force_z", "force_y@z", "force_z@z"));
  ASSERT_EQ(all.lines(), 8);
  EXPECT_EQ(all.frequency_hz(0), 13.0);
  EXPECT_EQ(all.outputs[0].value(7), 1.0);
  EXPECT_EQ(all.outputs[3].value(7), 2.0);
}

TEST(References, TableOfColumnsIsReadFromTheNames) {
  const References references = references_of({"force_y", "force_z", "force_z@z", "force_y@z"});
  EXPECT_THAT(references.outputs, ElementsAre("force_y", "force_z"));
  EXPECT_THAT(references.names, ElementsAre("", "z"));
  EXPECT_EQ(references.column, (Eigen::MatrixXi(2, 2) << 0, 3, 1, 2).finished());
  EXPECT_FALSE(references_of({"a", "b"}).several());
}

TEST(References, RefusesWhatCannotBeCombined) {
  const auto message = [](const NamedReference& second) {
    return tests::message_of([&] { combine_references({{"y", "y.csv", small_function()}, second}); });
  };
  EXPECT_THAT(message({"y", "z.csv", small_function()}),
              HasSubstr("z.csv: is the second reference named 'y'"));
  EXPECT_THAT(message({"a@b", "z.csv", small_function()}), HasSubstr("'a@b' cannot name a reference"));
  EXPECT_THAT(message({"z", "z.csv", small_function(0.7)}), HasSubstr("are not those of reference 'y'"));
  TransferFunction other = small_function();
  other.outputs[1].name = "force_x";
  EXPECT_THAT(message({"z", "z.csv", other}), HasSubstr("has outputs force_y, force_x"));
  other = small_function();
  other.outputs[1].unit = "kg";
  EXPECT_THAT(message({"z", "z.csv", other}), HasSubstr("force_z is in kg but in N/m"));
  other = small_function();
  other.exponential_decay = 1.0;
  EXPECT_THAT(message({"z", "z.csv", other}), HasSubstr("exponential window"));
  other = small_function();
  other.outputs[0].name = "force_y@x";
  TransferFunction first = other;
  EXPECT_THAT(tests::message_of([&] {
                combine_references({{"y", "y.csv", first}, {"z", "z.csv", other}});
              }),
              HasSubstr("is already one of several references"));
}

// What fit_rank_one's covariance promises, against many noises: two poles 0.15 bandwidths apart, three
// outputs, two references.
TEST(RankOneFit, StandardErrorsAreThoseOfTheScatter) {
  const double shape[2][3] = {{1.0, 0.4, -0.3}, {0.5, -0.9, 0.2}}, along[2][2] = {{1.0, 0.5}, {-0.4, 1.0}};
  const std::vector<Pole> truth = {{100.0, 0.02}, {100.3, 0.022}};
  std::vector<SimulatedMode> first, second;
  for (int r = 0; r < 2; ++r)
    for (int j = 0; j < 2; ++j) {
      SimulatedMode mode{truth[static_cast<std::size_t>(r)], {}};
      for (int o = 0; o < 3; ++o)
        mode.constant.push_back(shape[r][o] * along[r][j] * pole_scale(mode.pole, fem::Damping::structural));
      (j == 0 ? first : second).push_back(mode);
    }
  const Eigen::VectorXd f = lines(85.0, 117.0, 0.2);
  const TransferFunction clean = combine_references({{"y", "", function_of(first, f, FrfKind::receptance)},
                                                     {"z", "", function_of(second, f, FrfKind::receptance)}});
  const References references = references_of(output_names(clean));
  Eigen::MatrixXcd start(2, 2);
  for (int r = 0; r < 2; ++r)
    for (int j = 0; j < 2; ++j) start(j, r) = along[r][j];
  constexpr unsigned seeds = 150;
  Eigen::Vector4d squares = Eigen::Vector4d::Zero();
  double constant_squares = 0.0, excess = 0.0;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, std::vector<double>(6, 0.01), seed);
    const RankOneFit fit = fit_rank_one(tf, references, truth, start, {});
    ASSERT_TRUE(fit.converged);
    for (int r = 0; r < 2; ++r) {
      const auto& pole = fit.poles[static_cast<std::size_t>(r)];
      const auto& true_pole = truth[static_cast<std::size_t>(r)];
      squares(2 * r) += std::pow(pole.natural_frequency_hz - true_pole.natural_frequency_hz, 2.0) /
                        fit.covariance(2 * r, 2 * r);
      squares(2 * r + 1) +=
          std::pow(pole.loss_factor - true_pole.loss_factor, 2.0) / fit.covariance(2 * r + 1, 2 * r + 1);
      constant_squares += std::norm(fit.constant(r, 4) - second[static_cast<std::size_t>(r)].constant[1]) /
                          (2.0 * std::pow(fit.constant_sigma(r, 4), 2.0));
    }
    excess += fit.rank_excess.sum() / 2.0;
  }
  // Mean squares of so many normal numbers scatter by sqrt(2/seeds) = 0.12; three times that.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(squares(i) / seeds, 1.0, 0.35) << i;
  EXPECT_NEAR(constant_squares / (2.0 * seeds), 1.0, 0.25);
  // 2 (outputs - 1)(references - 1) = 4 real numbers are freed per pole; the two poles nearly coincide, so
  // that what is freed of one is freed of the other, and the participations' share comes on top of it.
  EXPECT_GT(excess / seeds, 2.0);
  EXPECT_LT(excess / seeds, 8.0);
}

// The chart of tests/bench/references_bench.cpp at three spacings.
TEST(References, TwoResolveWhatOneDoesNot) {
  constexpr unsigned seeds = 8;
  for (const double spacing : {0.05, 0.3, 1.0}) {
    const BowedWire bowed = bowed_for(spacing);
    EXPECT_NEAR(bowed.spacing, spacing, 0.01 * spacing);
    const ReferenceVerdicts one = reference_verdicts(bowed, 1, 0.01, seeds);
    for (const int references : {2, 3}) {
      const ReferenceVerdicts several = reference_verdicts(bowed, references, 0.01, seeds);
      EXPECT_EQ(several.resolved, seeds) << spacing << " bandwidths, " << references << " references";
      // Mean square of 8 seeds x 4 numbers: 1 +- 0.25, four times.
      EXPECT_LT(several.square_sum / static_cast<double>(several.squares), 2.0);
      // 0.0009 against 0.014, 0.005 and 0.003 bandwidths.
      if (one.squares > 0) {
        EXPECT_LT(several.frequency_sigma / static_cast<double>(several.squares),
                  0.5 * one.frequency_sigma / static_cast<double>(one.squares));
      }
    }
    if (spacing < 0.1) {
      EXPECT_LT(one.resolved, seeds);
    }
    EXPECT_EQ(one.wrong, 0u);
  }
}

TEST(References, SingleModeStaysOne) {
  std::vector<SimulatedMode> modes[2];
  for (int j = 0; j < 2; ++j) {
    const double scale = (j == 0 ? 1.0 : -0.6) * pole_scale({100.0, 0.02}, fem::Damping::structural);
    modes[j].push_back({{100.0, 0.02}, {scale, 0.3 * scale, -0.5 * scale}});
  }
  const Eigen::VectorXd f = lines(80.0, 130.0, 0.2);
  const TransferFunction clean =
      combine_references({{"y", "", function_of(modes[0], f, FrfKind::receptance)},
                          {"z", "", function_of(modes[1], f, FrfKind::receptance)}});
  unsigned flagged = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, std::vector<double>(6, 0.01), seed);
    const ModeSet set = identify_modes(tf);
    ASSERT_EQ(set.modes.size(), 1u) << "seed " << seed;
    flagged += set.modes[0].flags.empty() ? 0 : 1;
  }
  EXPECT_EQ(flagged, 0u);  // one in ten thousand
}

// The shaker's attachment moved the frequency by a fifth of a bandwidth: one shape, so not two modes.
TEST(References, SetUpThatChangedIsFlaggedAndNotTakenForTwoModes) {
  std::vector<SimulatedMode> modes[2];
  for (int j = 0; j < 2; ++j) {
    const Pole pole{100.0 + 0.4 * j, 0.02};
    const double scale = pole_scale(pole, fem::Damping::structural);
    modes[j].push_back({pole, {scale, 0.3 * scale, -0.5 * scale}});
  }
  const Eigen::VectorXd f = lines(80.0, 130.0, 0.2);
  TransferFunction tf = combine_references({{"y", "", function_of(modes[0], f, FrfKind::receptance)},
                                            {"z", "", function_of(modes[1], f, FrfKind::receptance)}});
  add_noise(tf, std::vector<double>(6, 0.01), 1);
  const ModeSet set = identify_modes(tf);
  ASSERT_FALSE(set.modes.empty());
  for (const Mode& mode : set.modes) EXPECT_FALSE(mode.flags.empty());
}

}  // namespace
}  // namespace struna::ident
