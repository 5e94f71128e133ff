#include "ident/transfer_estimate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "fem/error.hpp"
#include "ident/mode_identification.hpp"
#include "tests/folder.hpp"
#include "tests/ident/simulated_records.hpp"

namespace struna::ident {
namespace {

using testing::HasSubstr;

const std::vector<std::string> outputs = {"acceleration_x", "acceleration_y", "acceleration_z"};

EstimateOptions with(EstimateMethod method, double resolution_hz = 0.0) {
  EstimateOptions options;
  options.method = method;
  options.welch.resolution_hz = resolution_hz;
  return options;
}

std::vector<simulated::SimulatedMode> one_mode(double f, double eta) {
  return {{{f, eta}, {1.0, 0.7, -0.5}}};
}

// The demand on the default settings: 120 s at 2560 Hz, white force, 1 % noise: every loss factor within 1 %.
// The worst standard error is 0.1 %, of the lowest mode.
TEST(TransferEstimate, EightModesThroughRecordsHaveLossFactorsWithinOnePerCent) {
  const auto modes = simulated::eight_modes();
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Record record = simulated::record_of(modes, 120.0, 2560.0, 0.01, seed);
    const TransferEstimate estimate = estimate_transfer(record, "force", outputs, {});
    EXPECT_EQ(estimate.method, EstimateMethod::local_rational);
    const ModeSet found = identify_modes(restrict_band(estimate.function, 5.0, 1200.0), {});
    ASSERT_EQ(found.modes.size(), modes.size()) << "seed " << seed;
    for (std::size_t r = 0; r < modes.size(); ++r) {
      const Pole& truth = modes[r].pole;
      EXPECT_NEAR(found.modes[r].loss_factor / truth.loss_factor, 1.0, 0.01) << truth.natural_frequency_hz;
      EXPECT_NEAR(found.modes[r].natural_frequency_hz / truth.natural_frequency_hz, 1.0, 2e-4)
          << truth.natural_frequency_hz;
    }
  }
}

// Four lines of the record in the half-power band, where a Hann window more than doubles the damping.
TEST(TransferEstimate, ANarrowResonanceIsNotWidened) {
  const double f = 50.0, eta = 0.002;
  const Record record = simulated::record_of(one_mode(f, eta), 40.0, 512.0, 0.003, 1);
  const auto loss_factor = [&](EstimateMethod method) {
    ModeOptions options;
    options.frequencies_hz = {f};
    const auto tf = estimate_transfer(record, "force", outputs, with(method)).function;
    const ModeSet found = identify_modes(restrict_band(tf, 40.0, 60.0), options);
    return found.modes.size() == 1 ? found.modes[0].loss_factor : 0.0;
  };
  EXPECT_NEAR(loss_factor(EstimateMethod::local_rational) / eta, 1.0, 0.01);
  EXPECT_GT(loss_factor(EstimateMethod::welch) / eta, 1.5);
}

// Half-power bands of 4, 5, 8 and 20 lines of 0.25 Hz.
TEST(TransferEstimate, LinesAreHalvedWhereAResonanceWantsIt) {
  for (const auto& [lines, spacing] : {std::pair{4.0, 0.125}, {5.0, 0.125}, {8.0, 0.25}, {20.0, 0.25}}) {
    const Record record = simulated::record_of(one_mode(50.0, 0.25 * lines / 50.0), 30.0, 512.0, 0.005, 8);
    EXPECT_NEAR(estimate_transfer(record, "force", outputs, {}).resolution_hz, spacing, 1e-9) << lines;
  }
}

TEST(TransferEstimate, LinesAreThoseAskedForWhateverTheRecordsOwn) {
  const Record record = simulated::record_of(one_mode(50.0, 0.02), 31.7, 512.0, 0.01, 2);
  for (const double resolution : {0.15, 0.5, 2.0}) {  // 5, 16 and 63 lines of the record
    const auto estimate =
        estimate_transfer(record, "force", outputs, with(EstimateMethod::local_rational, resolution));
    EXPECT_EQ(estimate.resolution_hz, resolution);
    const TransferFunction& tf = estimate.function;
    double error = 0.0, sigma = 0.0;
    for (long i = 0; i < tf.lines(); ++i) {
      EXPECT_NEAR(std::remainder(tf.frequency_hz[i], resolution), 0.0, 1e-9);
      for (std::size_t k = 0; k < 3; ++k) {
        error += std::norm(tf.outputs[k].value[i] -
                           simulated::accelerance(one_mode(50.0, 0.02), k, tf.frequency_hz[i]));
        sigma += 2.0 * tf.outputs[k].sigma[i] * tf.outputs[k].sigma[i];
      }
    }
    EXPECT_NEAR(std::sqrt(error / sigma), 1.0, 0.25) << resolution;  // few independent lines at 2 Hz
  }
}

TEST(TransferEstimate, RepeatsAsFilesAndADelayGiveTheSameFunction) {
  const tests::Folder folder;
  const auto modes = one_mode(50.0, 0.02);
  std::vector<std::string> files;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    files.push_back((folder / ("r" + std::to_string(seed) + ".csv")).string());
    Record record = simulated::record_of(modes, 10.0 + seed, 512.0, 0.002, seed);
    // the force three samples late
    const long n = record.samples.rows();
    record.samples.col(0).tail(n - 3) = record.samples.col(0).head(n - 3).eval();
    write_record(record, files.back());
  }
  std::map<std::string, ChannelCorrection> corrections;
  corrections["force"].delay = 3.0 / 512.0;
  const auto estimate = estimate_transfer(files, "force", outputs, {}, corrections);
  EXPECT_EQ(estimate.method, EstimateMethod::local_rational);
  EXPECT_EQ(estimate.segments, 3.0);
  EXPECT_NEAR(estimate.resolution_hz, 12.0 / (5.0 * 11.0), 1e-6);  // twelve lines of the shortest in a window
  const TransferFunction& tf = estimate.function;
  double error = 0.0, whole = 0.0;
  for (long i = 0; i < tf.lines(); ++i) {
    if (tf.frequency_hz[i] < 20.0 || tf.frequency_hz[i] > 200.0) continue;
    const auto truth = simulated::accelerance(modes, 0, tf.frequency_hz[i]);
    error += std::norm(tf.outputs[0].value[i] - truth);
    whole += std::norm(truth);
  }
  EXPECT_LT(std::sqrt(error / whole), 0.01);  // noise 0.2 %, three samples of 5000 without partner
}

TEST(TransferEstimate, TheChoiceFollowsTheRecordAndSaysWhy) {
  const auto modes = one_mode(50.0, 0.02);
  Record noise = simulated::record_of(modes, 20.0, 512.0, 0.01, 4);
  Record sweep = noise, periodic = noise;
  for (long n = 0; n < noise.samples.rows(); ++n) {
    const double t = static_cast<double>(n) / 512.0;
    sweep.samples(n, 0) = std::sin(2.0 * std::numbers::pi * (5.0 + 4.0 * t) * t);
    periodic.samples.row(n) = noise.samples.row(n % 2048);
  }
  const auto chosen = [&](const Record& record, const EstimateOptions& options) {
    const auto estimate = estimate_transfer(record, "force", outputs, options);
    return to_string(estimate.method) + ": " + estimate.reason;
  };
  EXPECT_EQ(chosen(noise, {}), "local rational model: steady excitation that does not repeat itself");
  EXPECT_EQ(chosen(sweep, {}), "Welch: the excitation passes over the lines one after the other");
  EXPECT_EQ(chosen(periodic, {}), "mean over periods: the excitation repeats itself");
  EXPECT_EQ(estimate_transfer(sweep, "force", outputs, {}).window, Window::rectangular);
  EXPECT_EQ(estimate_transfer(periodic, "force", outputs, {}).resolution_hz, 0.25);
  EXPECT_THAT(chosen(noise, with(EstimateMethod::automatic, 0.1)),
              HasSubstr("Welch: a local model would have"));
  EXPECT_EQ(chosen(noise, with(EstimateMethod::local_polynomial)), "local polynomial model: asked for");
  EstimateOptions options;
  options.ratio = Estimator::h2;
  EXPECT_EQ(chosen(noise, options), "Welch: h2 is asked for");
  options = {};
  options.welch.window = Window::hann;
  EXPECT_EQ(chosen(noise, options), "Welch: a window is asked for");
  options = {};
  options.welch.overlap = 0.5;
  EXPECT_EQ(chosen(noise, options), "Welch: an overlap is asked for");
}

TEST(TransferEstimate, ACleanChirpThroughALocalModelGivesNumbersOrNoLine) {
  // As smooth as what leaks, and without noise: sums whose rounding is all that the model does not explain.
  const double sample_rate = 2000.0, duration = 20.0;
  const long samples = std::lround(duration * sample_rate);
  Fft fft(2 * samples);
  fft.input().setZero();
  for (long i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) / sample_rate;
    fft.input()[i] = std::sin(2.0 * std::numbers::pi * (20.0 * t + 380.0 / (2.0 * duration) * t * t));
  }
  Record record;
  record.sample_interval = 1.0 / sample_rate;
  record.channels = {{"displacement", Quantity::displacement}, {"force", Quantity::force}};
  record.samples.resize(samples, 2);
  record.samples.col(0) = fft.input().head(samples);
  Eigen::VectorXcd response = fft.transform();
  for (long i = 0; i < response.size(); ++i) {
    const double f = static_cast<double>(i) * sample_rate / static_cast<double>(2 * samples);
    response[i] *= 1e4 / std::complex<double>(1e4 - f * f, 2.0 * 0.01 * 100.0 * f);
  }
  record.samples.col(1) = inverse_transform(response, 2 * samples).head(samples);
  EstimateOptions options;
  options.method = EstimateMethod::local_rational;
  const TransferFunction tf = estimate_transfer(record, "displacement", {"force"}, options).function;
  EXPECT_TRUE(tf.outputs[0].value.allFinite());
  EXPECT_TRUE(tf.outputs[0].sigma.allFinite());
  EXPECT_GT(tf.lines(), 500);
}

TEST(TransferEstimate, EveryWordIsUnderstoodAndOthersAreRefused) {
  EXPECT_EQ(estimator_word("auto").method, EstimateMethod::automatic);
  EXPECT_EQ(estimator_word("local").method, EstimateMethod::local_rational);
  EXPECT_EQ(estimator_word("local-polynomial").method, EstimateMethod::local_polynomial);
  EXPECT_EQ(estimator_word("periodic").method, EstimateMethod::periodic);
  for (const char* word : {"welch", "h1", "h2", "hv", "amplitude-ratio"})
    EXPECT_EQ(estimator_word(word).method, EstimateMethod::welch) << word;
  EXPECT_EQ(estimator_word("hv").ratio, Estimator::hv);
  EXPECT_THROW(estimator_word("h9"), Error);
}

TEST(TransferEstimate, WhatAMethodCannotFollowIsRefused) {
  const Record record = simulated::record_of(one_mode(50.0, 0.02), 20.0, 512.0, 0.01, 5);
  const auto message = [&](const EstimateOptions& options) -> std::string {
    try {
      estimate_transfer(record, "force", outputs, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  for (const auto method :
       {EstimateMethod::local_rational, EstimateMethod::local_polynomial, EstimateMethod::periodic}) {
    EstimateOptions options = with(method);
    options.welch.window = Window::hann;
    EXPECT_THAT(message(options), HasSubstr("goes with Welch's method"));
    options = with(method);
    options.welch.impact = true;
    EXPECT_THAT(message(options), HasSubstr("goes with Welch's method"));
    options = with(method);
    options.welch.overlap = 0.5;
    EXPECT_THAT(message(options), HasSubstr("goes with Welch's method"));
    EXPECT_THAT(message(with(method, -1.0)), HasSubstr("resolution must be positive"));
  }
  EXPECT_THAT(message(with(EstimateMethod::periodic)), HasSubstr("does not repeat itself"));
  EXPECT_THAT(message(with(EstimateMethod::periodic, 1.0)), HasSubstr("leave it out"));
  EXPECT_THAT(message(with(EstimateMethod::local_rational, 0.05)), HasSubstr("coarser resolution"));
  Record still = record;
  still.samples.col(0).setConstant(1.0);
  EXPECT_THROW(estimate_transfer(still, "force", outputs, {}), Error);
}

}  // namespace
}  // namespace struna::ident
