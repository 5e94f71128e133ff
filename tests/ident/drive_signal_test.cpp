#include "ident/drive_signal.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fem/error.hpp"
#include "ident/fft.hpp"
#include "ident/transfer_estimate.hpp"
#include "tests/folder.hpp"
#include "tests/message_of.hpp"

namespace struna::ident {
namespace {

using ::testing::HasSubstr;
using Complex = std::complex<double>;

constexpr double sample_rate = 512.0;
constexpr double duration = 64.0;

/// One resonance each, loss factor 0.03 and 0.02: the shaker's motion over its drive, and force over motion.
Complex shaker(double f_hz) {
  return 1e-4 * 60.0 * 60.0 / Complex(60.0 * 60.0 - f_hz * f_hz, 0.03 * 60.0 * 60.0);
}
Complex structure(double f_hz) {
  return 1e4 * (0.3 + f_hz * f_hz / Complex(90.0 * 90.0 - f_hz * f_hz, 0.02 * 90.0 * 90.0));
}

struct Noises {
  double disturbance = 0.0;  ///< motion that the drive did not ask for, in parts of the shaker's
  double motion = 0.0;       ///< noise of the motion's sensor, in parts of its rms
  double force = 0.0;
};

/// Cut from the middle of a run four times as long: both ends find everything moving. `periodic`: the drive
/// repeats itself every second instead.
Record record_of(const Noises& noises, unsigned seed, bool periodic = false) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const long samples = std::lround(duration * sample_rate), whole = 4 * samples;
  Fft fft(whole);
  const auto drawn = [&](long period) {
    for (long i = 0; i < whole; ++i) fft.input()[i] = i < period ? normal(engine) : fft.input()[i - period];
    return Eigen::VectorXd(fft.input());
  };
  const Eigen::VectorXd drive = drawn(periodic ? std::lround(sample_rate) : whole);
  const Eigen::VectorXcd drive_lines = fft.transform();
  drawn(whole);
  const Eigen::VectorXcd disturbance_lines = noises.disturbance * fft.transform();
  Eigen::VectorXcd motion = drive_lines + disturbance_lines, force = motion;
  for (long i = 0; i < motion.size(); ++i) {
    const double f = static_cast<double>(i) * sample_rate / static_cast<double>(whole);
    motion[i] *= shaker(f);
    force[i] *= shaker(f) * structure(f);
  }
  motion[motion.size() - 1] = force[force.size() - 1] = 0.0;
  Record record;
  record.sample_interval = 1.0 / sample_rate;
  record.channels = {
      {"drive", Quantity::unknown}, {"motion", Quantity::displacement}, {"force", Quantity::force}};
  record.samples.resize(samples, 3);
  record.samples.col(0) = drive.segment(samples, samples);
  record.samples.col(1) = inverse_transform(motion, whole).segment(samples, samples);
  record.samples.col(2) = inverse_transform(force, whole).segment(samples, samples);
  for (const auto& [column, share] : {std::pair(1, noises.motion), std::pair(2, noises.force)}) {
    const double level =
        share * std::sqrt(record.samples.col(column).squaredNorm() / static_cast<double>(samples));
    for (double& value : record.samples.col(column)) value += level * normal(engine);
  }
  return record;
}

/// What estimates about the structure's resonance make of its function.
struct Errors {
  double bias = 0.0;     ///< mean of H/true - 1, real part
  double scatter = 0.0;  ///< rms of the same
  double stated = 0.0;   ///< rms sigma of the real part over |H|
  double covered = 0.0;  ///< share of lines at which both parts lie within 1.96 sigma
};

Errors errors(const Noises& noises, const std::string& drive_signal, int seeds) {
  Errors e;
  double lines = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    EstimateOptions options;
    options.drive_signal = drive_signal;
    const TransferEstimate estimate =
        estimate_transfer(record_of(noises, static_cast<unsigned>(seed)), "motion", {"force"}, options);
    EXPECT_EQ(estimate.method, EstimateMethod::local_rational);
    const auto& output = estimate.function.outputs.front();
    for (long i = 0; i < estimate.function.lines(); ++i) {
      const double f = estimate.function.frequency_hz[i];
      if (f < 30.0 || f > 120.0) continue;
      const Complex h = structure(f), error = output.value[i] - h;
      const double relative = (error / h).real();
      e.bias += relative;
      e.scatter += relative * relative;
      e.stated += std::pow(output.sigma[i] / std::abs(h), 2.0);
      e.covered += 0.5 * (std::abs(error.real()) < 1.96 * output.sigma[i] ? 1.0 : 0.0) +
                   0.5 * (std::abs(error.imag()) < 1.96 * output.sigma[i] ? 1.0 : 0.0);
      lines += 1.0;
    }
  }
  return {e.bias / lines, std::sqrt(e.scatter / lines), std::sqrt(e.stated / lines), e.covered / lines};
}

TEST(DriveSignal, TakesOutTheBiasOfNoiseOnTheMotion) {
  // Noise of 20 % of the motion's rms, white, where the motion is not: H1 comes out low by its share of each
  // line's power.
  const Noises noises{0.0, 0.2, 0.01};
  const Errors without = errors(noises, "", 6), with = errors(noises, "drive", 6);
  EXPECT_LT(without.bias, -0.2);
  EXPECT_LT(std::abs(with.bias),
            4.0 * with.scatter / std::sqrt(6.0 * 300.0));  // independent lines, some 300 a seed
  EXPECT_NEAR(with.covered, 0.95, 0.035);
}

TEST(DriveSignal, StatesTrueErrorsWhateverIsNoisy) {
  for (const Noises& noises : {Noises{0.0, 0.0, 0.02}, Noises{0.0, 0.02, 0.0}, Noises{0.0, 0.02, 0.02}}) {
    const Errors e = errors(noises, "drive", 4);
    EXPECT_NEAR(e.covered, 0.95, 0.035) << noises.motion << " " << noises.force;
    EXPECT_NEAR(e.stated / e.scatter, 1.0, 0.2) << noises.motion << " " << noises.force;
  }
}

TEST(DriveSignal, MotionThatItDidNotAskForIsNoNoise) {
  // As much motion again that the structure answers like any other: taken for noise it would make errors of
  // 100 %.
  const Errors e = errors({1.0, 0.0, 0.01}, "drive", 4);
  EXPECT_LT(e.stated, 0.05);
  // The common denominator's errors, which leave the ratio, are not quite out of what is stated.
  EXPECT_GT(e.stated, 0.9 * e.scatter);
  EXPECT_LT(e.stated, 1.4 * e.scatter);
  EXPECT_NEAR(e.covered, 0.96, 0.03);
}

TEST(DriveSignal, WhatRepeatsItselfIsAveragedOverItsPeriods) {
  EstimateOptions options;
  options.drive_signal = "drive";
  const TransferEstimate estimate =
      estimate_transfer(record_of({0.0, 0.2, 0.01}, 5, true), "motion", {"force"}, options);
  EXPECT_EQ(estimate.method, EstimateMethod::periodic);
  EXPECT_EQ(estimate.input.name, "motion");
  ASSERT_EQ(estimate.function.outputs.size(), 1u);
  EXPECT_EQ(estimate.function.outputs[0].name, "force");
  EXPECT_EQ(estimate.function.outputs[0].kind, FrfKind::dynamic_stiffness);
  double error = 0.0, lines = 0.0;
  for (long i = 0; i < estimate.function.lines(); ++i) {
    const double f = estimate.function.frequency_hz[i];
    if (f < 40.0 || f > 110.0) continue;
    error += (estimate.function.outputs[0].value[i] / structure(f)).real() - 1.0;
    lines += 1.0;
  }
  EXPECT_LT(std::abs(error / lines), 0.02);
}

TEST(DriveSignal, MayBeWrittenInVolts) {
  const tests::Folder folder;
  const Record record = record_of({0.0, 0.02, 0.02}, 1);
  std::string text = "time [s],drive [V],motion [m],force [N]\n";
  for (long i = 0; i < record.samples.rows(); ++i)
    text += fmt::format("{},{},{},{}\n", static_cast<double>(i) / sample_rate, record.samples(i, 0),
                        record.samples(i, 1), record.samples(i, 2));
  const std::string file = folder.write("volts.csv", text);
  EstimateOptions options;
  options.drive_signal = "drive";
  const TransferFunction from_file = estimate_transfer({file}, "motion", {"force"}, options).function;
  const TransferFunction from_memory = estimate_transfer(record, "motion", {"force"}, options).function;
  EXPECT_EQ(from_file.outputs[0].unit, "N/m");
  EXPECT_TRUE(from_file.outputs[0].value.isApprox(from_memory.outputs[0].value, 1e-9));
}

TEST(DriveSignal, RefusesWhatItCannotServe) {
  Record record = record_of({}, 1);
  const auto message = [&](EstimateOptions options, const std::string& drive) {
    options.drive_signal = drive;
    return tests::message_of([&] { estimate_transfer(record, "motion", {"force"}, options); });
  };
  EstimateOptions welch;
  welch.method = EstimateMethod::welch;
  EXPECT_THAT(message(welch, "drive"), HasSubstr("not with segments"));
  EstimateOptions impact;
  impact.welch.impact = true;
  EXPECT_THAT(message(impact, "drive"), HasSubstr("not with segments"));
  EXPECT_THAT(message({}, "dirve"), HasSubstr("no channel 'dirve'"));
  EXPECT_NE(message({}, "motion"), "no error");
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  for (double& value : record.samples.col(0)) value = normal(engine);
  EXPECT_THAT(message({}, "drive"), HasSubstr("is it the right channel?"));
  EXPECT_THROW(local_model_by_drive({}, 100.0, {}), Error);
}

}  // namespace
}  // namespace struna::ident
