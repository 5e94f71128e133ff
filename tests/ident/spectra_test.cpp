#include "ident/spectra.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "fem/error.hpp"
#include "ident/transfer_function.hpp"
#include "tests/folder.hpp"

namespace struna::ident {
namespace {

using testing::HasSubstr;

constexpr double dt = 1e-3;

Record record_of(const Eigen::MatrixXd& samples) {
  Record record;
  record.sample_interval = dt;
  record.samples = samples;
  record.channels = {{"displacement", Quantity::displacement, 0.0}};
  for (long k = 1; k < samples.cols(); ++k)
    record.channels.push_back({"force_" + std::to_string(k), Quantity::force, 0.0});
  return record;
}

Eigen::MatrixXd noise(long rows, long columns, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd samples(rows, columns);
  for (double& value : samples.reshaped()) value = normal(random);
  return samples;
}

WelchOptions with(Window window, double resolution_hz, double overlap = 2.0 / 3.0) {
  WelchOptions options;
  options.window = window;
  options.resolution_hz = resolution_hz;
  options.overlap = overlap;
  return options;
}

TEST(Spectra, PowerIsThatOfTheRecord) {
  // Parseval, exact for one rectangular segment up to rounding; odd and even lengths, prime ones too.
  for (const long n : {1000L, 999L, 997L, 16L}) {
    const Record record = record_of(noise(n, 2, 1));
    const Spectra spectra =
        welch_spectra(record, "displacement", {"force_1"}, with(Window::rectangular, 0.0));
    EXPECT_EQ(spectra.segments, 1.0);
    EXPECT_EQ(spectra.input_auto.size(), n / 2 + 1);
    for (long k = 0; k < 2; ++k) {
      const Eigen::VectorXd x = record.samples.col(k).array() - record.samples.col(k).mean();
      const double power = k == 0 ? spectra.input_auto.sum() : spectra.output_auto.col(0).sum();
      EXPECT_NEAR(power * spectra.resolution_hz / (x.squaredNorm() / static_cast<double>(n)), 1.0, 1e-12)
          << n;
    }
  }
}

TEST(Spectra, WhiteNoiseHasItsDensityUnderAHannWindow) {
  // One-sided density 2 sigma^2 dt; 600 segments, 250 lines: 0.3 % standard error.
  const Spectra spectra = welch_spectra(record_of(noise(200000, 2, 2)), "displacement", {"force_1"},
                                        with(Window::hann, 2.0, 0.5));
  EXPECT_NEAR(spectra.input_auto.segment(5, 240).mean() / (2.0 * dt), 1.0, 0.012);
}

TEST(Spectra, FilesInAStreamAndARecordInMemoryGiveTheSame) {
  const tests::Folder folder;
  for (const long rows : {4321L, 20000L}) {
    const Record record = record_of(noise(rows, 3, 3));
    const std::string file = (folder / "r.csv").string();
    write_record(record, file);
    Record read = read_record(file, {"displacement", "force_1", "force_2"});
    for (const WelchOptions& options :
         {WelchOptions{}, with(Window::hann, 3.3, 0.31), with(Window::rectangular, 7.0)}) {
      const Spectra a = welch_spectra({file}, "displacement", {"force_2", "force_1"}, options);
      const Spectra b = welch_spectra(read, "displacement", {"force_2", "force_1"}, options);
      EXPECT_EQ(a.segments, b.segments);
      EXPECT_TRUE(a.cross.isApprox(b.cross, 1e-13));
      EXPECT_TRUE(a.output_auto.isApprox(b.output_auto, 1e-13));
    }
  }
}

TEST(Spectra, RepeatsAreAveragedAndSegmentsNeverSpanThem) {
  const tests::Folder folder;
  std::vector<std::string> files;
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(51, 1);
  for (unsigned i = 0; i < 3; ++i) {
    files.push_back((folder / ("r" + std::to_string(i) + ".csv")).string());
    const Record record = record_of(noise(150 + 40 * static_cast<long>(i), 2, 10 + i));
    write_record(record, files.back());
    // 100 samples a segment, hop 50: 2, 2 and 3 segments.
    const Spectra one = welch_spectra(record, "displacement", {"force_1"}, with(Window::hann, 10.0, 0.5));
    EXPECT_EQ(one.segments, i < 2 ? 2.0 : 3.0);
    cross += one.segments / 7.0 * one.cross.real();
  }
  const Spectra all = welch_spectra(files, "displacement", {"force_1"}, with(Window::hann, 10.0, 0.5));
  EXPECT_EQ(all.segments, 7.0);
  EXPECT_LT((all.cross.real() - cross).norm(), 1e-8 * cross.norm());  // nine written digits
  EXPECT_NEAR(all.effective_averages, 2 * 2.0 / (1.0 + 1.0 / 36.0) + 3.0 / (1.0 + 4.0 / 3.0 / 36.0), 1e-9);
}

TEST(Spectra, AutomaticResolutionFollowsTheDurationAlone) {
  // T/7.5, reduced to a length without large primes, for any content and rate.
  for (const double interval : {1e-3, 1.0 / 2560.0}) {
    Record record = record_of(noise(std::lround(30.0 / interval), 2, 4));
    record.sample_interval = interval;
    const Spectra spectra = welch_spectra(record, "displacement", {"force_1"}, WelchOptions{});
    EXPECT_NEAR(spectra.resolution_hz, 0.25, 1e-12);
    EXPECT_EQ(spectra.window, Window::hann);
    EXPECT_GT(spectra.effective_averages, 12.0);
    EXPECT_LT(spectra.effective_averages, 20.0);
  }
}

TEST(Spectra, ALengthWithLargePrimesIsShortenedAndSaysSo) {
  const Record record = record_of(noise(20000, 2, 5));
  const Spectra hann =
      welch_spectra(record, "displacement", {"force_1"}, with(Window::hann, 1000.0 / 1009.0));
  EXPECT_NEAR(hann.resolution_hz, 1000.0 / 1008.0, 1e-12);
  // Whole periods of a periodic excitation must stay whole.
  const Spectra plain =
      welch_spectra(record, "displacement", {"force_1"}, with(Window::rectangular, 1000.0 / 1009.0));
  EXPECT_NEAR(plain.resolution_hz, 1000.0 / 1009.0, 1e-12);
}

TEST(Spectra, APeriodicSignalInARectangularSegmentDoesNotLeak) {
  Eigen::MatrixXd samples(10000, 2);
  for (long i = 0; i < samples.rows(); ++i) {
    samples(i, 0) = std::cos(2.0 * std::numbers::pi * 50.0 * static_cast<double>(i) * dt);
    samples(i, 1) = std::sin(2.0 * std::numbers::pi * 50.0 * static_cast<double>(i) * dt);
  }
  const Spectra spectra =
      welch_spectra(record_of(samples), "displacement", {"force_1"}, with(Window::rectangular, 5.0));
  // Amplitude 1: mean square 1/2, all in line 10; sine over cosine is -i.
  EXPECT_NEAR(spectra.input_auto[10] * spectra.resolution_hz, 0.5, 1e-12);
  EXPECT_LT(spectra.input_auto.sum() - spectra.input_auto[10], 1e-20 + 1e-20 * spectra.input_auto[10]);
  const std::complex<double> h = spectra.cross(10, 0) / spectra.input_auto[10];
  EXPECT_NEAR(std::abs(h - std::complex<double>(0.0, -1.0)), 0.0, 1e-12);
}

TEST(Spectra, ADelayedChannelIsPutBackExactly) {
  // y lags x by 7 samples; told so, H = 1 but for the segments' ends, where 7 of 1000 samples differ.
  const Eigen::MatrixXd x = noise(100000, 1, 6);
  Eigen::MatrixXd samples = Eigen::MatrixXd::Zero(x.rows() - 7, 2);
  samples.col(0) = x.bottomRows(x.rows() - 7);
  samples.col(1) = x.topRows(x.rows() - 7);
  Record record = record_of(samples);
  record.channels[1].delay = 7 * dt;
  const Spectra told = welch_spectra(record, "displacement", {"force_1"}, with(Window::hann, 1.0));
  const Eigen::VectorXcd h = told.cross.col(0).cwiseQuotient(told.input_auto.cast<std::complex<double>>());
  EXPECT_LT((h.segment(1, 498).array() - 1.0).abs().mean(), 5e-3);
  // A delay of the input has the other sign, and the same one on both cancels.
  record.channels[0].delay = 7 * dt;
  const Spectra both = welch_spectra(record, "displacement", {"force_1"}, with(Window::hann, 1.0));
  record.channels[0].delay = record.channels[1].delay = 0.0;
  const Spectra none = welch_spectra(record, "displacement", {"force_1"}, with(Window::hann, 1.0));
  EXPECT_TRUE(both.cross.isApprox(none.cross, 1e-14));
  record.channels[1].delay = 0.2;
  EXPECT_THROW(welch_spectra(record, "displacement", {"force_1"}, with(Window::hann, 1.0)), Error);
}

/// Linear sweep from 5 to 200 Hz over the record.
Eigen::VectorXd sweep(long rows) {
  const double duration = static_cast<double>(rows) * dt;
  return Eigen::VectorXd::NullaryExpr(rows, [&](Eigen::Index i) {
    const double t = static_cast<double>(i) * dt;
    return std::sin(2.0 * std::numbers::pi * (5.0 * t + 0.5 * 195.0 * t * t / duration));
  });
}

TEST(Spectra, AutomaticWindowTakesSweepsAndBurstsInOneSegmentAndNoiseInMany) {
  const long rows = 20000;
  Eigen::MatrixXd samples = noise(rows, 2, 7);
  EXPECT_EQ(welch_spectra(record_of(samples), "displacement", {"force_1"}, {}).window, Window::hann);
  const Eigen::MatrixXd sensor_noise = 1e-3 * noise(rows, 2, 8);
  samples.col(0) = sweep(rows);
  samples.col(1) = 2.0 * samples.col(0);
  const Spectra swept = welch_spectra(record_of(samples + sensor_noise), "displacement", {"force_1"}, {});
  EXPECT_EQ(swept.window, Window::rectangular);
  EXPECT_EQ(swept.segments, 1.0);
  samples = noise(rows, 2, 7);
  samples.bottomRows(rows - 2500).setZero();
  EXPECT_EQ(welch_spectra(record_of(samples + sensor_noise), "displacement", {"force_1"}, {}).segments, 1.0);
  // A steady sine is there all the time.
  for (long i = 0; i < rows; ++i) samples(i, 0) = std::sin(0.3 * static_cast<double>(i));
  EXPECT_EQ(welch_spectra(record_of(samples + sensor_noise), "displacement", {"force_1"}, {}).window,
            Window::hann);
  // A resolution asked for is kept.
  samples.col(0) = sweep(rows);
  EXPECT_EQ(
      welch_spectra(record_of(samples), "displacement", {"force_1"}, with(Window::automatic, 1.0)).window,
      Window::hann);
}

TEST(Spectra, ASweepCutOffInMotionDoesNotSpoilItsLines) {
  // y = x lagged, y_n = 0.9 y_{n-1} + 0.1 x_n, from a chirp of constant acceleration that begins in motion, y
  // in its steady state: the sweep has not come from rest, and no record says so.
  const long rows = 40000, before = 200;
  const double duration = static_cast<double>(rows) * dt;
  Eigen::MatrixXd samples(rows, 2);
  double y = 0.0;
  for (long i = -before; i < rows; ++i) {
    const double t = static_cast<double>(i) * dt;
    const double hz = 5.0 + 195.0 * std::max(t, 0.0) / duration;
    const double phase = t < 0.0 ? 5.0 * t : 5.0 * t + 0.5 * 195.0 * t * t / duration;
    const double x = std::sin(2.0 * std::numbers::pi * phase) / (hz * hz);
    y = 0.9 * y + 0.1 * x;
    if (i >= 0) samples.row(i) << x, y;
  }
  const auto worst = [&](Window window) {
    const Spectra spectra = welch_spectra(record_of(samples), "displacement", {"force_1"}, with(window, 0.0));
    const TransferFunction function = estimate_transfer_function(spectra, Estimator::h1);
    double error = 0.0;
    for (long k = 0; k < function.lines(); ++k) {
      const double f = function.frequency_hz[k];
      if (f < 12.0 || f > 190.0) continue;
      const std::complex<double> z = std::polar(1.0, -2.0 * std::numbers::pi * f * dt);
      const std::complex<double> exact = 0.1 / (1.0 - 0.9 * z);
      error = std::max(error, std::abs(function.outputs[0].value[k] / exact - 1.0));
    }
    return error;
  };
  EXPECT_LT(worst(Window::automatic), 5e-3);    // measured 2.7e-3: what the fading leaves
  EXPECT_GT(worst(Window::rectangular), 2e-2);  // as asked: not faded
}

TEST(Spectra, AHitNearTheBeginningIsNotFaded) {
  // Pre-trigger of half a per cent: a hit within the first hundredth of the record.
  const long rows = 20000;
  Eigen::MatrixXd samples = Eigen::MatrixXd::Zero(rows, 2);
  for (int i = 0; i < 20; ++i) samples(100 + i, 0) = std::sin(std::numbers::pi * (i + 0.5) / 20.0);
  for (long i = 1; i < rows; ++i) samples(i, 1) = 0.999 * samples(i - 1, 1) + samples(i, 0);
  const Spectra found = welch_spectra(record_of(samples), "displacement", {"force_1"}, {});
  const Spectra as_is =
      welch_spectra(record_of(samples), "displacement", {"force_1"}, with(Window::rectangular, 0.0));
  EXPECT_EQ(found.segments, 1.0);
  EXPECT_TRUE(found.cross.isApprox(as_is.cross, 1e-14));
}

TEST(Spectra, RepeatedSweepsAreEachOneSegmentAndGiveCoherence) {
  const tests::Folder folder;
  std::vector<std::string> files;
  for (unsigned i = 0; i < 4; ++i) {
    Eigen::MatrixXd samples = 0.1 * noise(8000 + 100 * static_cast<long>(i), 2, 20 + i);
    samples.col(0).head(8000) += sweep(8000);
    samples.col(1).head(8000) += sweep(8000);
    files.push_back((folder / ("s" + std::to_string(i) + ".csv")).string());
    write_record(record_of(samples), files.back());
  }
  const Spectra spectra = welch_spectra(files, "displacement", {"force_1"}, {});
  EXPECT_EQ(spectra.segments, 4.0);
  EXPECT_EQ(spectra.effective_averages, 4.0);
  EXPECT_NEAR(spectra.resolution_hz, 1.0 / 8.3, 1e-9);  // the longest
  EXPECT_EQ(estimate_transfer_function(spectra, Estimator::h1).outputs[0].coherence.size(), 4149);
}

/// A hammer hit and the free decay that follows, exactly as a sum of one mode sampled: x'' = ... with pole
/// -sigma + i omega_d.
Record hit_and_decay(long rows, long at, double natural_hz, double zeta, double offset) {
  const double omega = 2.0 * std::numbers::pi * natural_hz;
  const double damped = omega * std::sqrt(1.0 - zeta * zeta);
  Record record;
  record.sample_interval = dt;
  record.channels = {{"force", Quantity::force, 0.0}, {"displacement", Quantity::displacement, 0.0}};
  record.samples = Eigen::MatrixXd::Constant(rows, 2, offset);
  record.samples(at, 0) += 1.0;
  for (long i = at; i < rows; ++i) {
    const double t = static_cast<double>(i - at) * dt;
    record.samples(i, 1) += std::exp(-zeta * omega * t) * std::sin(damped * t) / damped;
  }
  return record;
}

/// Transform of the sampled decay at s, by its geometric series.
std::complex<double> decay_transform(std::complex<double> s, double natural_hz, double zeta) {
  const double omega = 2.0 * std::numbers::pi * natural_hz;
  const std::complex<double> pole(-zeta * omega, omega * std::sqrt(1.0 - zeta * zeta));
  const auto series = [&](std::complex<double> p) { return 1.0 / (1.0 - std::exp((p - s) * dt)); };
  return (series(pole) - series(std::conj(pole))) / (2.0 * std::complex<double>(0.0, pole.imag()));
}

TEST(Spectra, AnExponentialWindowShiftsTheTransformByItsDecayExactly) {
  // 40 Hz, zeta 0.2 %: the decay reaches exp(-0.5) in the second recorded. The window's 1 % makes the cut
  // invisible to 1e-2 of a truncated rest: exp(-(0.5 + 13.8)) with an end value of 1e-6.
  const Record record = hit_and_decay(1100, 100, 40.0, 0.002, 3.0);
  WelchOptions options;
  options.impact = true;
  options.window = Window::exponential;
  options.exponential_end = 1e-6;
  const Spectra spectra = welch_spectra(record, "force", {"displacement"}, options);
  EXPECT_NEAR(spectra.exponential_decay, -std::log(1e-6) / 1.0, 1e-9);
  EXPECT_THAT(spectra.warnings, testing::IsEmpty());
  const TransferFunction tf = estimate_transfer_function(spectra, Estimator::h1);
  EXPECT_EQ(tf.exponential_decay, spectra.exponential_decay);
  double worst = 0.0;
  double largest = 0.0;
  for (long i = 0; i < tf.lines(); ++i) {
    const std::complex<double> s(tf.exponential_decay, 2.0 * std::numbers::pi * tf.frequency_hz[i]);
    const std::complex<double> exact = decay_transform(s, 40.0, 0.002);
    worst = std::max(worst, std::abs(tf.outputs[0].value[i] - exact));
    largest = std::max(largest, std::abs(exact));
  }
  // What the end cuts off, 6e-7, over the bandwidth that the window gives (peak 1/(2 a omega)).
  EXPECT_LT(worst, 2e-6 * largest);
  EXPECT_EQ(tf.outputs[0].coherence.size(), 0);
  EXPECT_EQ(tf.outputs[0].sigma.size(), 0);
}

TEST(Spectra, AResponseThatIsCutOffIsWarnedOf) {
  WelchOptions options;
  options.impact = true;
  EXPECT_THAT(
      welch_spectra(hit_and_decay(1100, 100, 40.0, 0.002, 0.0), "force", {"displacement"}, options).warnings,
      testing::ElementsAre(HasSubstr("'displacement' still moves")));
  EXPECT_THAT(
      welch_spectra(hit_and_decay(1100, 100, 40.0, 0.05, 0.0), "force", {"displacement"}, options).warnings,
      testing::IsEmpty());
}

TEST(Spectra, HitsOfDifferentStrengthAverageToTheSameFunction) {
  const tests::Folder folder;
  std::vector<std::string> files;
  for (const double strength : {1.0, 2.5, 0.4}) {
    Record record = hit_and_decay(2000, 200, 40.0, 0.05, 0.0);
    record.samples *= strength;
    record.samples.col(0).array() += 5.0;  // offset of the force channel
    files.push_back((folder / ("h" + std::to_string(files.size()) + ".csv")).string());
    write_record(record, files.back());
  }
  WelchOptions options;
  options.impact = true;
  const Spectra spectra = welch_spectra(files, "force", {"displacement"}, options);
  EXPECT_EQ(spectra.effective_averages, 3.0);
  const TransferFunction tf = estimate_transfer_function(spectra, Estimator::h1);
  EXPECT_GT(tf.outputs[0].coherence.minCoeff(), 1.0 - 1e-9);
  for (const long i : {10L, 75L, 400L}) {
    const std::complex<double> s(0.0, 2.0 * std::numbers::pi * tf.frequency_hz[i]);
    const std::complex<double> exact = decay_transform(s, 40.0, 0.05);
    EXPECT_LT(std::abs(tf.outputs[0].value[i] - exact),
              1e-6 * std::abs(exact) + 1e-9);  // nine digits written
  }
}

/// The error of the peak's half-power loss factor of a discrete resonator, by an exact inverse at the peak:
/// |H| there.
double peak_ratio(double lines_per_bandwidth, Estimator estimator) {
  // y_n = 2 r cos(w) y_{n-1} - r^2 y_{n-2} + x_n, 100 Hz, half-power bandwidth B = -ln(r)/(pi dt).
  const double bandwidth = 2.0;
  const double r = std::exp(-std::numbers::pi * bandwidth * dt);
  const double w = 2.0 * std::numbers::pi * 100.0 * dt;
  Eigen::MatrixXd samples = noise(1200000, 2, 9);
  double y1 = 0.0, y2 = 0.0;
  for (long i = 0; i < samples.rows(); ++i) {
    const double y = 2.0 * r * std::cos(w) * y1 - r * r * y2 + samples(i, 0);
    samples(i, 1) = y;
    y2 = y1;
    y1 = y;
  }
  const double resolution = bandwidth / lines_per_bandwidth;
  const TransferFunction tf = estimate_transfer_function(
      welch_spectra(record_of(samples), "displacement", {"force_1"}, with(Window::hann, resolution)),
      estimator);
  const long line = std::lround(100.0 / (tf.frequency_hz[1] - tf.frequency_hz[0])) - 1;
  const std::complex<double> z1 = std::polar(1.0, -2.0 * std::numbers::pi * tf.frequency_hz[line] * dt);
  const std::complex<double> exact = 1.0 / (1.0 - 2.0 * r * std::cos(w) * z1 + r * r * z1 * z1);
  return std::abs(tf.outputs[0].value[line]) / std::abs(exact);
}

/// What is expected of H1: white input and its response share a segment only for lags within it, so that the
/// impulse response is seen through the window's autocorrelation, (1 - u)(2 + cos 2 pi u)/3 + sin(2 pi u)/(2
/// pi) for Hann, u = lag/T.
double expected_peak_ratio(double lines_per_bandwidth) {
  const double decay = std::numbers::pi * lines_per_bandwidth;
  double sum = 0.0;
  const int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    const double u = (i + 0.5) / steps;
    const double turn = 2.0 * std::numbers::pi * u;
    sum += std::exp(-decay * u) *
           ((1.0 - u) * (2.0 + std::cos(turn)) / 3.0 + std::sin(turn) / (2.0 * std::numbers::pi));
  }
  return decay * sum / steps;
}

TEST(Spectra, LeakageLowersThePeakAsItsFormulaTells) {
  // 600 to 4800 effective averages at a coherence above 0.9: 0.2 to 1 % standard error.
  for (const double lines : {2.0, 4.0, 8.0})
    EXPECT_NEAR(peak_ratio(lines, Estimator::h1), expected_peak_ratio(lines), 0.012) << lines;
  // The table of docs/transfer_function.md.
  EXPECT_NEAR(expected_peak_ratio(2.0), 0.807, 0.0006);
  EXPECT_NEAR(expected_peak_ratio(4.0), 0.931, 0.0006);
  EXPECT_NEAR(expected_peak_ratio(8.0), 0.980, 0.0006);
  EXPECT_GT(peak_ratio(4.0, Estimator::h2), peak_ratio(4.0, Estimator::h1));
}

TEST(Spectra, WrongOptionsAndRecordsAreRefused) {
  const tests::Folder folder;
  const Record record = record_of(noise(400, 3, 11));
  const auto message = [&](const WelchOptions& options, const Record& of,
                           const std::string& input = "displacement",
                           const std::vector<std::string>& outputs = {"force_1"}) -> std::string {
    try {
      welch_spectra(of, input, outputs, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  WelchOptions o;
  EXPECT_THAT(message(with(Window::hann, -1.0), record), HasSubstr("resolution"));
  EXPECT_THAT(message(with(Window::hann, NAN), record), HasSubstr("resolution"));
  EXPECT_THAT(message(with(Window::hann, 10.0, 0.95), record), HasSubstr("overlap"));
  EXPECT_THAT(message(with(Window::hann, 10.0, -0.1), record), HasSubstr("overlap"));
  EXPECT_THAT(message(with(Window::exponential, 0.0), record), HasSubstr("impact"));
  o.impact = true;
  o.window = Window::hann;
  EXPECT_THAT(message(o, record), HasSubstr("suppress the hit"));
  for (const double end : {0.0, 1.0, -1.0}) {
    o.exponential_end = end;
    EXPECT_THAT(message(o, record), HasSubstr("exponential_end"));
  }
  EXPECT_THAT(message(with(Window::hann, 1.0), record),
              HasSubstr("record: 400 samples are too few for a segment of 1000"));
  EXPECT_THAT(message(with(Window::hann, 100.0), record), HasSubstr("at least 16"));
  EXPECT_THAT(message({}, record_of(noise(50, 2, 1))), HasSubstr("at least 16"));
  EXPECT_THAT(message({}, record, "force"), HasSubstr("no channel 'force'"));
  EXPECT_THAT(message({}, record, "displacement", {}), HasSubstr("at least one output"));
  EXPECT_THAT(message({}, record, "displacement", {"force_1", "force_1"}), HasSubstr("named twice"));
  EXPECT_THAT(message({}, record, "displacement", {"displacement"}), HasSubstr("named twice"));
  Record bad = record;
  bad.samples(3, 1) = NAN;
  EXPECT_THAT(message({}, bad), HasSubstr("not finite"));
  bad = record;
  bad.sample_interval = 0.0;
  EXPECT_THAT(message({}, bad), HasSubstr("sample interval"));
  bad = record;
  bad.samples.col(0).setConstant(2.0);
  EXPECT_THAT(message({}, bad), HasSubstr("is constant"));

  const auto message_of_files = [](const std::vector<std::string>& files) -> std::string {
    try {
      welch_spectra(files, "displacement", {"force_1"}, {});
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string a = (folder / "a.csv").string();
  const std::string b = (folder / "b.csv").string();
  write_record(record, a);
  Record other = record;
  other.sample_interval = 1.01e-3;
  write_record(other, b);
  EXPECT_THAT(message_of_files({a, b}), HasSubstr("b.csv: has a sample interval of 0.00101 s"));
  other = record;
  other.channels[1].quantity = Quantity::acceleration;
  write_record(other, b);
  EXPECT_THAT(message_of_files({a, b}), HasSubstr("b.csv:1: column 'force_1' is in m/s^2 here and in N in"));
  EXPECT_THAT(message_of_files({}), HasSubstr("at least one record"));
}

}  // namespace
}  // namespace struna::ident
