#include "ident/line_blocks.hpp"

#include <gtest/gtest.h>

#include "ident/pole_fit.hpp"
#include "simulated_modes.hpp"

namespace struna::ident {
namespace {

const std::vector<simulated::SimulatedMode> two_modes = {{{100.0, 0.05}, {1.0, 0.5}},
                                                         {{150.0, 0.02}, {-0.4, 1.0}}};
const std::vector<Pole> start = {{100.5, 0.04}, {150.2, 0.025}};

TransferFunction noisy(double spacing_hz, unsigned seed) {
  TransferFunction tf =
      simulated::function_of(two_modes, simulated::lines(50.0, 250.0, spacing_hz), FrfKind::receptance);
  simulated::add_noise(tf, {1e-7, 1e-7}, seed);
  return tf;
}

TEST(LineBlocks, TheirNumberHardlyGrowsWithThatOfTheLines) {
  const long coarse = in_blocks(noisy(0.02, 1), start).lines(),
             fine = in_blocks(noisy(0.005, 1), start).lines();
  EXPECT_LT(fine, 300);
  EXPECT_LT(static_cast<double>(fine), 1.3 * static_cast<double>(coarse));
}

TEST(LineBlocks, LinesThatAreFewAreLeftAsTheyAre) {
  const TransferFunction tf = noisy(4.0, 1);
  const TransferFunction blocks = in_blocks(tf, start);
  EXPECT_EQ(blocks.frequency_hz, tf.frequency_hz);
  // Rounding: weighted and divided by the weight.
  EXPECT_LT((blocks.outputs[1].value - tf.outputs[1].value).norm(), 1e-14 * tf.outputs[1].value.norm());
}

TEST(LineBlocks, KeepTheInformationOfTheLines) {
  const TransferFunction tf = noisy(0.02, 2);
  const TransferFunction blocks = in_blocks(tf, start);
  const PoleFit all = fit_poles(tf, start, {}), few = fit_poles(blocks, start, {});
  for (long i = 0; i < 4; ++i) {
    // The average over a block of a tenth of the distance is off by a thousandth of what it stands for.
    EXPECT_NEAR(std::sqrt(few.covariance(i, i) / all.covariance(i, i)), 1.0, 0.1);
  }
  for (std::size_t r = 0; r < 2; ++r)
    EXPECT_NEAR(few.poles[r].natural_frequency_hz, all.poles[r].natural_frequency_hz,
                2e-3 * bandwidth_hz(all.poles[r]));
}

TEST(LineBlocks, WeighTheLinesBySigma) {
  TransferFunction tf = noisy(0.02, 3);
  tf.outputs[0].value.setOnes();
  tf.outputs[0].value(0) = 3.0;
  tf.outputs[0].sigma.setOnes();
  tf.outputs[0].sigma(0) = 1e9;  // nothing is known of it
  const TransferFunction blocks = in_blocks(tf, start);
  EXPECT_NEAR(blocks.outputs[0].value(0).real(), 1.0, 1e-12);
  // The weights are those of all lines together.
  EXPECT_NEAR(blocks.outputs[1].sigma.cwiseAbs2().cwiseInverse().sum() /
                  tf.outputs[1].sigma.cwiseAbs2().cwiseInverse().sum(),
              1.0, 1e-9);
}

}  // namespace
}  // namespace struna::ident
