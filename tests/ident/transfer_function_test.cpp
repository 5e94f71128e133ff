#include "ident/transfer_function.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

using testing::HasSubstr;
constexpr FrfKind all_kinds[] = {FrfKind::dynamic_stiffness, FrfKind::impedance, FrfKind::apparent_mass,
                                 FrfKind::receptance,        FrfKind::mobility,  FrfKind::accelerance};
constexpr double dt = 1e-3;

/// A resonator y_n = a1 y_{n-1} + a2 y_{n-2} + x_n at 60 Hz, bandwidth 12 Hz, with noise on input and output;
/// its function is exact.
struct Resonator {
  double r = std::exp(-std::numbers::pi * 12.0 * dt);
  double cosine = std::cos(2.0 * std::numbers::pi * 60.0 * dt);
  std::complex<double> exact(double hz) const {
    const std::complex<double> z1 = std::polar(1.0, -2.0 * std::numbers::pi * hz * dt);
    return 1.0 / (1.0 - 2.0 * r * cosine * z1 + r * r * z1 * z1);
  }
  Record record(long rows, double input_noise, double output_noise, unsigned seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Record record;
    record.sample_interval = dt;
    record.channels = {{"force", Quantity::force, 0.0}, {"displacement", Quantity::displacement, 0.0}};
    record.samples.resize(rows, 2);
    double y1 = 0.0, y2 = 0.0;
    for (long i = -500; i < rows; ++i) {  // 500 samples to settle
      const double x = normal(random);
      const double y = 2.0 * r * cosine * y1 - r * r * y2 + x;
      y2 = y1;
      y1 = y;
      if (i < 0) continue;
      record.samples(i, 0) = x + input_noise * normal(random);
      record.samples(i, 1) = y + output_noise * normal(random);
    }
    return record;
  }
};

WelchOptions one_hertz(double overlap = 2.0 / 3.0) {
  WelchOptions options;
  options.resolution_hz = 1.0;
  options.overlap = overlap;
  options.window = Window::hann;
  return options;
}

TransferFunction estimate(const Record& record, Estimator estimator, double overlap = 2.0 / 3.0) {
  return estimate_transfer_function(welch_spectra(record, "force", {"displacement"}, one_hertz(overlap)),
                                    estimator);
}

TEST(TransferFunction, WordsUnitsAndQuantitiesNameTheKinds) {
  for (const FrfKind kind : all_kinds) {
    EXPECT_EQ(frf_kind(to_string(kind)), kind);
    EXPECT_EQ(kind_of_unit(unit_of(kind)), kind);
  }
  EXPECT_EQ(kind_of_unit("1"), FrfKind::transmissibility);
  EXPECT_EQ(kind_of_unit("chan2/chan1"), FrfKind::unknown);
  EXPECT_EQ(kind_of(Quantity::force, Quantity::displacement), FrfKind::dynamic_stiffness);
  EXPECT_EQ(kind_of(Quantity::force, Quantity::acceleration), FrfKind::apparent_mass);
  EXPECT_EQ(kind_of(Quantity::acceleration, Quantity::force), FrfKind::accelerance);
  EXPECT_EQ(kind_of(Quantity::velocity, Quantity::velocity), FrfKind::transmissibility);
  EXPECT_EQ(kind_of(Quantity::velocity, Quantity::displacement), FrfKind::unknown);
  for (const Estimator estimator : {Estimator::h1, Estimator::h2, Estimator::hv, Estimator::amplitude_ratio})
    EXPECT_EQ(estimator_kind(to_string(estimator)), estimator);
  EXPECT_THROW(frf_kind("stiffness"), Error);
  EXPECT_THROW(frf_kind("transmissibility"), Error);
  EXPECT_THROW(estimator_kind("H1"), Error);
}

TEST(TransferFunction, SigmaIsTrueAndTheNoiseAssumedLeavesNoBias) {
  // 40 records of 20 s, 38 averages each: a line's error over its sigma has unit variance. Lines away from
  // the resonance, where leakage is far below sigma. Hv is free of bias only for equal relative noise on
  // both, so its noise is small: a bias of 0.02^2/(2 |H|^2) is a tenth of sigma.
  struct Case {
    Estimator estimator;
    double input_noise;
    double output_noise;
  };
  const Resonator resonator;
  for (const Case& c :
       {Case{Estimator::h1, 0.0, 0.3}, Case{Estimator::h2, 0.3, 0.0}, Case{Estimator::hv, 0.02, 0.02}}) {
    double sum = 0.0, sum_squares = 0.0;
    long count = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
      const TransferFunction tf =
          estimate(resonator.record(20000, c.input_noise, c.output_noise, seed), c.estimator);
      for (long i = 130; i < 310; i += 3) {
        const std::complex<double> exact = resonator.exact(tf.frequency_hz[i]);
        // Along H and across it: a bias of the magnitude would show in the first.
        const std::complex<double> z =
            (tf.outputs[0].value[i] - exact) / tf.outputs[0].sigma[i] * std::abs(exact) / exact;
        sum += z.real();
        sum_squares += std::norm(z);
        ++count;
      }
    }
    // 2400 lines of two parts, three lines apart independent: standard error 0.02 of the variance and of the
    // mean; sigma's own scatter with n = 38 adds 2/38 to the variance.
    EXPECT_NEAR(sum_squares / (2.0 * static_cast<double>(count)), 1.05, 0.1) << to_string(c.estimator);
    EXPECT_NEAR(sum / static_cast<double>(count), 0.0, 0.15) << to_string(c.estimator);
  }
}

TEST(TransferFunction, SigmaIsTrueWithFewAverages) {
  // Three segments without overlap: Student's t with 4 degrees of freedom has variance 2, the median of |t|
  // is 0.7407; with n in place of n - 1 it would be 0.7407 sqrt(3/2).
  const Resonator resonator;
  std::vector<double> z;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const TransferFunction tf = estimate(resonator.record(3000, 0.0, 1.0, seed), Estimator::h1, 0.0);
    for (long i = 150; i < 400; i += 4)
      z.push_back(std::abs((tf.outputs[0].value[i] - resonator.exact(tf.frequency_hz[i])).real()) /
                  tf.outputs[0].sigma[i]);
  }
  std::nth_element(z.begin(), z.begin() + static_cast<long>(z.size() / 2), z.end());
  EXPECT_NEAR(z[z.size() / 2], 0.7407, 0.04);  // 3800 values: 2 % standard error
}

TEST(TransferFunction, NoiseBiasesH1DownAndH2UpAsItsPowerTells) {
  // Input noise power a^2 lowers H1 by 1/(1 + a^2); output noise b^2/|H|^2 raises H2 by 1 + b^2/|H|^2; Hv is
  // the geometric mean.
  const Resonator resonator;
  const double a = 0.4, b = 0.5;
  const Record record = resonator.record(600000, a, b, 5);
  const TransferFunction h1 = estimate(record, Estimator::h1);
  const TransferFunction h2 = estimate(record, Estimator::h2);
  const TransferFunction hv = estimate(record, Estimator::hv);
  const TransferFunction ratio = estimate(record, Estimator::amplitude_ratio);
  double r1 = 0.0, r2 = 0.0, e1 = 0.0, e2 = 0.0;
  for (long i = 100; i < 300; ++i) {
    const double exact = std::abs(resonator.exact(h1.frequency_hz[i]));
    r1 += std::abs(h1.outputs[0].value[i]) / exact;
    r2 += std::abs(h2.outputs[0].value[i]) / exact;
    e1 += 1.0 / (1.0 + a * a);
    e2 += 1.0 + b * b / (exact * exact);
    EXPECT_NEAR(std::abs(hv.outputs[0].value[i]),
                std::sqrt(std::abs(h1.outputs[0].value[i]) * std::abs(h2.outputs[0].value[i])), 1e-12);
    EXPECT_NEAR(std::abs(ratio.outputs[0].value[i]), std::abs(hv.outputs[0].value[i]), 1e-12);
    EXPECT_EQ(ratio.outputs[0].value[i].imag(), 0.0);
  }
  // 200 lines of 1200 averages: below 0.2 %.
  EXPECT_NEAR(r1 / e1, 1.0, 0.005);
  EXPECT_NEAR(r2 / e2, 1.0, 0.005);
}

TEST(TransferFunction, NothingDependsOnTheUnits) {
  const Resonator resonator;
  const Record record = resonator.record(20000, 0.3, 0.3, 6);
  Record scaled = record;
  scaled.samples.col(0) *= 1e6;
  scaled.samples.col(1) *= 1e-5;
  for (const Estimator estimator :
       {Estimator::h1, Estimator::h2, Estimator::hv, Estimator::amplitude_ratio}) {
    const auto a = estimate(record, estimator).outputs[0];
    const auto b = estimate(scaled, estimator).outputs[0];
    EXPECT_TRUE((1e11 * b.value).isApprox(a.value, 1e-12)) << to_string(estimator);
    EXPECT_TRUE((1e11 * b.sigma).isApprox(a.sigma, 1e-9)) << to_string(estimator);
    EXPECT_TRUE(b.coherence.isApprox(a.coherence, 1e-12)) << to_string(estimator);
  }
}

TEST(TransferFunction, AmplitudeRatioHasATrueSigma) {
  const Resonator resonator;
  double sum_squares = 0.0;
  long count = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const TransferFunction tf =
        estimate(resonator.record(20000, 0.0, 0.5, 100 + seed), Estimator::amplitude_ratio);
    for (long i = 150; i < 400; i += 5) {
      const double exact = std::sqrt(std::norm(resonator.exact(tf.frequency_hz[i])) + 0.25);
      sum_squares += std::pow((tf.outputs[0].value[i].real() - exact) / tf.outputs[0].sigma[i], 2);
      ++count;
    }
  }
  EXPECT_NEAR(sum_squares / static_cast<double>(count), 1.0,
              0.12);  // 3000 values, and the scatter of sigma itself
}

TEST(TransferFunction, CoherenceStaysInItsBounds) {
  const Resonator resonator;
  for (const double level : {0.0, 1e-9, 1.0, 1e6}) {
    const auto output = estimate(resonator.record(5000, 0.0, level, 8), Estimator::h1).outputs[0];
    EXPECT_GE(output.coherence.minCoeff(), 0.0);
    EXPECT_LE(output.coherence.maxCoeff(), 1.0);
    EXPECT_TRUE(output.sigma.allFinite());
  }
}

TEST(TransferFunction, LinesWithoutMeaningAreLeftOut) {
  const TransferFunction even = estimate(Resonator().record(5000, 0.0, 0.0, 9), Estimator::h1);
  EXPECT_EQ(even.frequency_hz[0], 1.0);
  EXPECT_EQ(even.frequency_hz[even.lines() - 1], 499.0);
  Spectra silent =
      welch_spectra(Resonator().record(5000, 0.0, 0.0, 9), "force", {"displacement"}, one_hertz());
  silent.input_auto[7] = 0.0;
  silent.cross(7, 0) = 0.0;
  EXPECT_EQ(estimate_transfer_function(silent, Estimator::h1).lines(), even.lines() - 1);
  silent.input_auto.setZero();
  EXPECT_THROW(estimate_transfer_function(silent, Estimator::h1), Error);
}

/// k - m omega^2 + i omega c as a dynamic stiffness, from 0 Hz.
TransferFunction stiffness(bool with_zero_line = true) {
  TransferFunction tf;
  tf.frequency_hz = Eigen::VectorXd::LinSpaced(50, with_zero_line ? 0.0 : 0.5, 24.5);
  TransferFunction::Output output;
  output.name = "force";
  output.kind = FrfKind::dynamic_stiffness;
  output.unit = "N/m";
  const Eigen::ArrayXd omega = 2.0 * std::numbers::pi * tf.frequency_hz.array();
  output.value.resize(50);
  output.value.real() = 800.0 - 0.8 * omega.square();
  output.value.imag() = 3.0 * omega;
  output.sigma = Eigen::VectorXd::Constant(50, 2.0);
  output.coherence = Eigen::VectorXd::Constant(50, 0.9);
  tf.outputs = {output};
  return tf;
}

TEST(TransferFunction, ConversionsGoRoundAndBack) {
  for (const double decay : {0.0, 4.6}) {
    TransferFunction tf = stiffness(false);
    tf.exponential_decay = decay;
    for (const FrfKind first : all_kinds) {
      for (const FrfKind second : all_kinds) {
        const TransferFunction back =
            convert(convert(convert(tf, first), second), FrfKind::dynamic_stiffness);
        EXPECT_TRUE(back.outputs[0].value.isApprox(tf.outputs[0].value, 1e-13));
        EXPECT_TRUE(back.outputs[0].sigma.isApprox(tf.outputs[0].sigma, 1e-12));
        EXPECT_EQ(back.outputs[0].unit, "N/m");
        EXPECT_EQ(back.exponential_decay, decay);
      }
    }
  }
}

TEST(TransferFunction, ApparentMassIsMinusStiffnessOverOmegaSquared) {
  const TransferFunction tf = stiffness();
  const TransferFunction mass = convert(tf, FrfKind::apparent_mass);
  EXPECT_EQ(mass.lines(), tf.lines() - 1);  // 0 Hz is dropped
  const double omega = 2.0 * std::numbers::pi * mass.frequency_hz[4];
  EXPECT_LT(std::abs(mass.outputs[0].value[4] + tf.outputs[0].value[5] / (omega * omega)), 1e-12);
  EXPECT_NEAR(mass.outputs[0].sigma[4], 2.0 / (omega * omega), 1e-12);
  EXPECT_EQ(mass.outputs[0].unit, "kg");
  EXPECT_EQ(mass.outputs[0].coherence[4], 0.9);
  const TransferFunction receptance = convert(tf, FrfKind::receptance);
  EXPECT_EQ(receptance.lines(), tf.lines());
  EXPECT_LT(std::abs(receptance.outputs[0].value[5] * tf.outputs[0].value[5] - 1.0), 1e-14);
  EXPECT_NEAR(receptance.outputs[0].sigma[5], 2.0 / std::norm(tf.outputs[0].value[5]), 1e-15);
}

TEST(TransferFunction, AnExponentialWindowMovesDerivativesOffTheAxis) {
  TransferFunction tf = stiffness(false);
  tf.exponential_decay = 5.0;
  const std::complex<double> s(5.0, 2.0 * std::numbers::pi * tf.frequency_hz[3]);
  EXPECT_LT(
      std::abs(convert(tf, FrfKind::apparent_mass).outputs[0].value[3] - tf.outputs[0].value[3] / (s * s)),
      1e-12);
}

TEST(TransferFunction, OnlyOneDrivePointFunctionIsInverted) {
  TransferFunction two = stiffness();
  two.outputs.push_back(two.outputs[0]);
  EXPECT_NO_THROW(convert(two, FrfKind::apparent_mass));
  EXPECT_THROW(convert(two, FrfKind::receptance), Error);
  TransferFunction unknown = stiffness();
  unknown.outputs[0].kind = FrfKind::unknown;
  EXPECT_THROW(convert(unknown, FrfKind::receptance), Error);
  unknown.outputs[0].kind = FrfKind::transmissibility;
  EXPECT_THROW(convert(unknown, FrfKind::receptance), Error);
  EXPECT_THROW(convert(stiffness(), FrfKind::transmissibility), Error);
  EXPECT_THROW(convert(stiffness(), FrfKind::unknown), Error);
  TransferFunction zero = stiffness();
  zero.outputs[0].value[3] = 0.0;
  EXPECT_THROW(convert(zero, FrfKind::receptance), Error);
}

TEST(TransferFunction, ABandKeepsItsEndsAndRefusesToBeEmpty) {
  const TransferFunction part = restrict_band(stiffness(), 2.0, 5.0);
  EXPECT_EQ(part.lines(), 7);
  EXPECT_EQ(part.frequency_hz[0], 2.0);
  EXPECT_EQ(part.outputs[0].sigma.size(), 7);
  EXPECT_EQ(part.outputs[0].value[0], stiffness().outputs[0].value[4]);
  try {
    restrict_band(stiffness(), 30.0, 40.0);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no line between 30 and 40 Hz: the lines reach from 0 to 24.5 Hz"));
  }
}

}  // namespace
}  // namespace struna::ident
