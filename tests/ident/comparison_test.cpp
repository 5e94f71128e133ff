#include "ident/comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

using std::complex;

/// Two hysteretic modes as apparent mass on `lines` lines.
TransferFunction two_modes(long lines, double lo, double hi, double shift = 1.0, double gain = 1.0) {
  TransferFunction tf;
  tf.frequency_hz = Eigen::VectorXd::LinSpaced(lines, lo, hi);
  TransferFunction::Output output;
  output.name = "force_y";
  output.kind = FrfKind::apparent_mass;
  output.unit = "kg";
  output.value.resize(lines);
  for (long i = 0; i < lines; ++i) {
    const double w = tf.frequency_hz[i];
    output.value[i] =
        gain * (complex<double>(300.0) / complex<double>(2500.0 * shift * shift - w * w, 100.0) -
                complex<double>(500.0) / complex<double>(22500.0 * shift * shift - w * w, 900.0));
  }
  tf.outputs = {output};
  return tf;
}

TEST(Comparison, EqualFunctionsAgreeInFull) {
  const TransferFunction tf = two_modes(401, 10.0, 210.0);
  const Comparison c = compare(tf, tf);
  ASSERT_EQ(c.outputs.size(), 1u);
  EXPECT_NEAR(c.outputs[0].frac, 1.0, 1e-14);  // rounding
  EXPECT_EQ(c.outputs[0].log_magnitude_error_db, 0.0);
  EXPECT_EQ(c.outputs[0].lines, 401);
  EXPECT_EQ(c.lo_hz, 10.0);
  EXPECT_EQ(c.hi_hz, 210.0);
  ASSERT_EQ(c.outputs[0].peaks.size(), 2u);
  // The hysteretic resonances lie at 50 and 150 Hz; the other mode's share moves the top of |H| by eta/2 of a
  // bandwidth at most.
  EXPECT_NEAR(c.outputs[0].peaks[0].measured_hz, 50.0, 0.5);
  EXPECT_NEAR(c.outputs[0].peaks[1].measured_hz, 150.0, 1.5);
  EXPECT_EQ(c.outputs[0].peaks[0].amplitude_db, 0.0);
  EXPECT_EQ(peak_frequency_error(c.outputs[0]), 0.0);
}

TEST(Comparison, AGainIsALevelAndNoLossOfFrac) {
  const Comparison c = compare(two_modes(401, 10.0, 210.0), two_modes(401, 10.0, 210.0, 1.0, 2.0));
  const double level = 20.0 * std::log10(2.0);
  EXPECT_NEAR(c.outputs[0].frac, 1.0, 1e-14);
  EXPECT_NEAR(c.outputs[0].mean_db, level, 1e-12);
  EXPECT_NEAR(c.outputs[0].log_magnitude_error_db, level, 1e-12);
  EXPECT_NEAR(c.outputs[0].largest_db, level, 1e-12);
  EXPECT_NEAR(peak_amplitude_error_db(c.outputs[0]), level, 1e-12);
}

TEST(Comparison, FracIsItsFormula) {
  const TransferFunction a = two_modes(101, 10.0, 210.0);
  const TransferFunction b = two_modes(101, 10.0, 210.0, 1.02);
  complex<double> cross = 0.0;
  double aa = 0.0, bb = 0.0;
  for (long i = 0; i < 101; ++i) {
    cross += std::conj(b.outputs[0].value[i]) * a.outputs[0].value[i];
    aa += std::norm(a.outputs[0].value[i]);
    bb += std::norm(b.outputs[0].value[i]);
  }
  EXPECT_NEAR(compare(a, b).outputs[0].frac, std::norm(cross) / aa / bb, 1e-14);
}

TEST(Comparison, PeaksShiftWithTheResonances) {
  const Comparison c = compare(two_modes(2001, 10.0, 210.0), two_modes(2001, 10.0, 210.0, 1.01));
  for (const PeakDifference& peak : c.outputs[0].peaks) {
    // Parabola through lines a tenth of a hertz apart, on peaks of 2 and 6 Hz width.
    EXPECT_NEAR(peak.predicted_hz / peak.measured_hz, 1.01, 2e-4);
  }
}

/// two_modes with complex noise of standard deviation sigma in either part, told or not.
TransferFunction noisy_modes(double sigma, bool told, unsigned seed) {
  TransferFunction tf = two_modes(2001, 10.0, 210.0);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  for (auto& value : tf.outputs[0].value) value += complex<double>(normal(random), normal(random));
  if (told) tf.outputs[0].sigma = Eigen::VectorXd::Constant(2001, sigma);
  return tf;
}

TEST(Comparison, NoiseIsNoPeak) {
  // The peaks are 3 and 0.6 high; a noise of 0.03 buries all that lies between and beside them.
  for (const bool told : {true, false}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const Comparison c = compare(noisy_modes(0.03, told, seed), two_modes(2001, 10.0, 210.0));
      ASSERT_EQ(c.outputs[0].peaks.size(), 2u) << "seed " << seed << (told ? "" : ", sigma not told");
      // The top of noisy lines lies within a quarter of the bandwidths, 2 and 6 Hz.
      EXPECT_NEAR(c.outputs[0].peaks[0].measured_hz, 50.0, 0.5);
      EXPECT_NEAR(c.outputs[0].peaks[1].measured_hz, 150.0, 1.5);
    }
  }
}

TEST(Comparison, NoiseShareIsWhatFracLacks) {
  const TransferFunction truth = two_modes(2001, 10.0, 210.0);
  const Comparison c = compare(noisy_modes(0.1, true, 3), truth);
  EXPECT_GT(c.outputs[0].noise_share, 0.05);
  // 2001 lines: the noise power scatters by 1/sqrt(2001), 2 %; the cross terms of signal and noise add as
  // much.
  EXPECT_NEAR(1.0 - c.outputs[0].frac, c.outputs[0].noise_share, 0.1 * c.outputs[0].noise_share);
  EXPECT_NEAR(c.outputs[0].measured_rms, std::sqrt(truth.outputs[0].value.squaredNorm() / 2001 + 0.02), 0.01);
}

TEST(Comparison, OutputsThatAreNotDefinedTakeNoPartInTheMean) {
  TransferFunction measured = two_modes(401, 10.0, 210.0);
  measured.outputs.push_back(measured.outputs[0]);
  measured.outputs[1].name = "force_z";
  TransferFunction predicted = two_modes(401, 10.0, 210.0, 1.0, 2.0);
  predicted.outputs.push_back(predicted.outputs[0]);
  predicted.outputs[1].name = "force_z";
  predicted.outputs[1].value.setZero();
  const Comparison c = compare(measured, predicted);
  EXPECT_TRUE(is_defined(c.outputs[0]));
  EXPECT_FALSE(is_defined(c.outputs[1]));
  EXPECT_NEAR(mean_level_error_db(c), 20.0 * std::log10(2.0), 1e-12);
  EXPECT_TRUE(std::isnan(mean_level_error_db({})));
}

TEST(Comparison, InterpolatesAtSecondOrderBetweenCoarserLines) {
  const TransferFunction fine = two_modes(1601, 10.0, 210.0);
  const auto error = [&](long lines) {
    return compare(fine, two_modes(lines, 10.0, 210.0)).outputs[0].largest_db;
  };
  const double order = std::log2(error(401) / error(801));
  EXPECT_GT(order, 1.6);  // linear interpolation: 2 when the lines resolve the peaks
  EXPECT_LT(order, 2.4);
}

TEST(Comparison, ConvertsThePredictedMotionQuantity) {
  const TransferFunction mass = two_modes(401, 10.0, 210.0);
  const TransferFunction stiffness = convert(mass, FrfKind::dynamic_stiffness);
  const Comparison c = compare(mass, stiffness);
  EXPECT_EQ(c.outputs[0].kind, FrfKind::apparent_mass);
  EXPECT_NEAR(c.outputs[0].frac, 1.0, 1e-13);  // rounding of omega^2
  EXPECT_NEAR(c.outputs[0].log_magnitude_error_db, 0.0, 1e-12);
}

TEST(Comparison, KeepsToTheCommonBandAndOutputs) {
  TransferFunction measured = two_modes(401, 10.0, 210.0);
  measured.outputs.push_back(measured.outputs[0]);
  measured.outputs.back().name = "force_z";
  const TransferFunction predicted = two_modes(401, 60.0, 260.0);
  const Comparison c = compare(measured, predicted);
  EXPECT_NEAR(c.lo_hz, 60.0, 1e-9);
  EXPECT_NEAR(c.hi_hz, 210.0, 1e-9);
  EXPECT_EQ(c.not_compared, std::vector<std::string>{"force_z"});
  const Comparison band = compare(measured, predicted, 100.0, 120.0);
  EXPECT_NEAR(band.lo_hz, 100.0, 1e-9);
  EXPECT_NEAR(band.hi_hz, 120.0, 1e-9);
}

TEST(Comparison, RefusesWhatHasNothingInCommon) {
  const TransferFunction measured = two_modes(401, 10.0, 210.0);
  TransferFunction other_name = measured;
  other_name.outputs[0].name = "force_z";
  EXPECT_THROW(compare(measured, other_name), Error);
  EXPECT_THROW(compare(measured, two_modes(11, 300.0, 400.0)), Error);
  EXPECT_THROW(compare(measured, TransferFunction{}), Error);
  EXPECT_THROW(compare(measured, measured, 20.0, 10.0), Error);
  TransferFunction receptance = measured;
  receptance.outputs[0].kind = FrfKind::receptance;
  receptance.outputs.push_back(receptance.outputs[0]);
  EXPECT_NO_THROW(compare(receptance, receptance));
  TransferFunction unknown = measured;
  unknown.outputs[0].kind = FrfKind::unknown;
  unknown.outputs[0].unit = "N/lightyear";
  EXPECT_THROW(compare(measured, unknown), Error);
  EXPECT_NO_THROW(compare(unknown, unknown));
  TransferFunction other_unit = unknown;
  other_unit.outputs[0].unit = "N/furlong";
  EXPECT_THROW(compare(unknown, other_unit), Error);
}

TEST(Comparison, WritesOneRowPerOutputUnderThePromisedHeader) {
  TransferFunction measured = two_modes(401, 10.0, 210.0);
  const std::string file = (std::filesystem::temp_directory_path() / "struna_comparison_test.csv").string();
  write_comparison(compare(measured, two_modes(401, 10.0, 210.0, 1.0, 2.0)), file);
  std::ifstream in(file);
  std::string header, row, rest;
  std::getline(in, header);
  std::getline(in, row);
  EXPECT_THAT(header, ::testing::StartsWith("output,frac [-],log_magnitude_error [dB],"));
  EXPECT_THAT(row, ::testing::StartsWith("force_y,"));
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
  EXPECT_FALSE(std::getline(in, rest));
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace struna::ident
