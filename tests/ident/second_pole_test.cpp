#include "ident/second_pole.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "ident/mode_flags.hpp"
#include "simulated_doublet.hpp"

namespace struna::ident::simulated {
namespace {

struct OnePole {
  SecondPole second;
  double loss_factor = 0.0;
};

/// One pole fitted to `tf` with the residual terms of a band, judged within eight bandwidths.
OnePole of_one_pole(const TransferFunction& tf, const Pole& start,
                    fem::Damping damping = fem::Damping::structural) {
  PoleFitOptions options;
  options.damping = damping;
  const PoleFit fit = fit_poles(tf, {start}, options);
  const Pole& pole = fit.poles.front();
  const double scale = pole_scale(pole, damping);
  const long n = 320, first = (tf.lines() - n) / 2;
  LinesOfPole lines;
  lines.g.resize(n);
  for (long i = 0; i < n; ++i)
    lines.g(i) = scale * pole_function(pole, 2.0 * std::numbers::pi * tf.frequency_hz(first + i), damping);
  lines.height = fit.constant.row(0).transpose() / scale;
  lines.sigma.resize(n, lines.height.size());
  for (std::size_t k = 0; k < tf.outputs.size(); ++k)
    lines.sigma.col(static_cast<long>(k)) = tf.outputs[k].sigma.segment(first, n);
  lines.residual = fit.residual.middleRows(first, n);
  return {second_pole(lines), pole.loss_factor};
}

constexpr double eta = 0.02, f = 100.0;

/// Modes `spacing` bandwidths apart, of these heights, with noise of `noise`; 20 lines in a bandwidth.
TransferFunction pair(double spacing, const std::vector<double>& first, const std::vector<double>& second,
                      double noise, unsigned seed, fem::Damping damping = fem::Damping::structural) {
  std::vector<SimulatedMode> modes = {{{f * (1.0 - 0.5 * spacing * eta), eta}, {}},
                                      {{f * (1.0 + 0.5 * spacing * eta), eta}, {}}};
  for (std::size_t r = 0; r < 2; ++r)
    for (const double height : r == 0 ? first : second)
      modes[r].constant.push_back(height * pole_scale(modes[r].pole, damping));
  TransferFunction tf = function_of(modes, lines(70.0, 130.0, 0.1), FrfKind::receptance, damping);
  add_noise(tf, std::vector<double>(first.size(), noise), seed);
  return tf;
}

struct Shares {
  double noticed = 0.0;
  double told = 0.0;  ///< noticed or hinted at
};

Shares shares(double spacing, const std::vector<double>& first, const std::vector<double>& second,
              double noise, unsigned seeds, fem::Damping damping = fem::Damping::structural) {
  Shares of;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const SecondPole one =
        of_one_pole(pair(spacing, first, second, noise, seed, damping), {f, eta}, damping).second;
    of.noticed += one.noticed ? 1.0 / seeds : 0.0;
    of.told += one.noticed || one.hinted ? 1.0 / seeds : 0.0;
  }
  return of;
}

TEST(SecondPole, NoncentralityIsThatOfNinetyFivePercent) {
  constexpr int draws = 20000;  // which scatter by 0.15 %; the normal root is good to 1 %
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  for (const auto& [threshold, freedom] : {std::pair{14.0, 2}, {23.0, 6}, {60.0, 10}}) {
    const double shift = std::sqrt(noticed_noncentrality(threshold, freedom));
    int above = 0;
    for (int i = 0; i < draws; ++i) {
      double sum = std::pow(normal(engine) + shift, 2.0);
      for (int k = 1; k < freedom; ++k) sum += std::pow(normal(engine), 2.0);
      above += sum > threshold ? 1 : 0;
    }
    EXPECT_NEAR(static_cast<double>(above) / draws, 0.95, 0.015) << threshold << " " << freedom;
  }
}

TEST(SecondPole, QuantilesAreThoseOfChiSquare) {
  // Tables; Wilson and Hilferty are good to 5 % at one degree of freedom, to 1 % from four on.
  EXPECT_NEAR(chi_square_quantile(1.0, 3.29), 12.1, 0.6);
  EXPECT_NEAR(chi_square_quantile(4.0, 3.29), 20.0, 0.4);
  EXPECT_NEAR(chi_square_quantile(10.0, 2.05), 21.1, 0.1);
}

TEST(SecondPole, OnePoleIsHardlyEverTakenForTwo) {
  constexpr unsigned seeds = 500;
  for (const std::vector<double>& height : {std::vector{1.0}, {1.0, 0.3, -0.5}}) {
    const Shares of = shares(0.0, height, height, 0.01, seeds);
    EXPECT_LE(of.noticed, 0.006) << height.size();  // one in a thousand
    EXPECT_LE(of.told, 0.08) << height.size();      // one in 20, and three times the scatter of so many
  }
}

/// Spacing in bandwidths of each, of modes whose common pole states just their spacing in bandwidths of its
/// own, which are wider.
double stated_spacing(const std::vector<double>& first, const std::vector<double>& second, double noise) {
  double spacing = 0.1;
  for (int pass = 0; pass < 30; ++pass) {
    TransferFunction tf = pair(spacing, first, second, 1e-9, 1);
    for (auto& output : tf.outputs) output.sigma.setConstant(noise);
    const OnePole one = of_one_pole(tf, {f, eta});
    spacing = 0.5 * (spacing + one.second.resolves_from * one.loss_factor / eta);
  }
  return spacing;
}

TEST(SecondPole, PairAtTheStatedDistanceIsToldInNinetyFiveOfAHundred) {
  constexpr unsigned seeds = 150;
  for (const double noise : {0.02, 0.05}) {
    const double spacing = stated_spacing({1.0}, {1.0}, noise);
    // Less twice the scatter of so many; the third order adds to what is stated.
    EXPECT_GT(shares(spacing, {1.0}, {1.0}, noise, seeds).told, 0.91) << noise;
    EXPECT_LT(shares(0.5 * spacing, {1.0}, {1.0}, noise, seeds).told, 0.2) << noise;
  }
}

TEST(SecondPole, PairOfOtherShapeAtTheStatedDistanceIsToldToo) {
  constexpr unsigned seeds = 150;  // 1.8 %
  constexpr double noise = 0.05;
  // 60 degrees apart; two thirds of their difference are taken for what is visible, here it is all.
  const double half = std::tan(std::numbers::pi / 6.0) / std::sqrt(2.0);
  const std::vector<double> first = {1.0, half, half}, second = {1.0, -half, -half};
  for (const fem::Damping damping : {fem::Damping::structural, fem::Damping::viscous}) {
    const double from =
        of_one_pole(pair(0.0, first, second, noise, 1, damping), {f, eta}, damping).second.resolves_from;
    EXPECT_GT(shares(from, first, second, noise, seeds, damping).told, 0.97);
    EXPECT_NEAR(shares(std::sqrt(2.0 / 3.0) * from, first, second, noise, seeds, damping).told, 0.95, 0.06);
  }
}

TEST(SecondPole, DistanceFallsWithNoiseAsTheOrderOfWhatShows) {
  const auto from = [](const std::vector<double>& height, double noise) {
    return of_one_pole(pair(0.0, height, height, noise, 1), {f, eta}).second.resolves_from;
  };
  // The pole's own noise: 3 %.
  EXPECT_NEAR(from({1.0}, 0.16) / from({1.0}, 0.04), 2.0, 0.15);            // root
  EXPECT_NEAR(from({1.0, 0.7}, 0.08) / from({1.0, 0.7}, 0.04), 2.0, 0.15);  // first order
  EXPECT_LT(from({1.0, 0.7}, 0.04), 0.7 * from({1.0}, 0.04));               // two see more
  EXPECT_NEAR(from({1.0}, 1e-5) / from({1.0}, 1e-6), 1.0, 0.01);            // the model's own error
}

TEST(SecondPole, AnOutputOfNoiseAloneHelpsNot) {
  TransferFunction one = pair(0.0, {1.0}, {1.0}, 0.04, 1), two = pair(0.0, {1.0, 0.0}, {1.0, 0.0}, 0.04, 1);
  two.outputs[1].value *= 1e3;
  two.outputs[1].sigma *= 1e3;
  const double from = of_one_pole(two, {f, eta}).second.resolves_from;
  EXPECT_GE(from, of_one_pole(one, {f, eta}).second.resolves_from);
  EXPECT_TRUE(std::isfinite(from));
}

TEST(SecondPole, FewLinesTellNothing) {
  LinesOfPole lines;
  lines.g = Eigen::VectorXcd::Ones(7);
  lines.height = Eigen::VectorXcd::Ones(1);
  lines.sigma = Eigen::MatrixXd::Ones(7, 1);
  lines.residual = Eigen::MatrixXcd::Zero(7, 1);
  EXPECT_FALSE(second_pole(lines).noticed);
  EXPECT_TRUE(std::isnan(second_pole(lines).resolves_from));
}

TEST(SecondPole, ModesSayFromWhereOnTheyWouldShow) {
  const auto modes_at = [](double noise) { return identify_modes(pair(0.0, {0.5}, {0.5}, noise, 1)).modes; };
  const auto clear = modes_at(0.005), hidden = modes_at(0.04);
  ASSERT_EQ(clear.size(), 1u);
  ASSERT_EQ(hidden.size(), 1u);
  EXPECT_LT(clear[0].resolves_from, unseen_pair);
  EXPECT_TRUE(clear[0].flags.empty());
  EXPECT_GT(hidden[0].resolves_from, unseen_pair);
  EXPECT_TRUE(hidden[0].has(ModeFlag::may_be_two));
  Mode two = hidden[0];
  two.flags = {ModeFlag::double_mode};
  EXPECT_FALSE(may_be_two(two));  // noticed: nothing hides
}

}  // namespace
}  // namespace struna::ident::simulated
