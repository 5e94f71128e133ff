#include "ident/local_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
using testing::HasSubstr;

/// Lines 0 .. count - 1 of a record: white input X, outputs H(f) X + T(f) + noise.
RecordSpectrum record(double line_hz, long count,
                      const std::vector<std::function<Complex(double)>>& functions,
                      const std::function<Complex(double)>& transient, double noise, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, std::sqrt(0.5));
  const auto draw = [&] {
    const double re = normal(random), im = normal(random);
    return Complex(re, im);
  };
  RecordSpectrum spectrum;
  spectrum.line_spacing_hz = line_hz;
  spectrum.lines.resize(count, 1 + static_cast<long>(functions.size()));
  for (long k = 0; k < count; ++k) {
    const double f = static_cast<double>(k) * line_hz;
    const Complex x = draw();
    spectrum.lines(k, 0) = x;
    for (std::size_t o = 0; o < functions.size(); ++o)
      spectrum.lines(k, static_cast<long>(o) + 1) = functions[o](f) * x + transient(f) + noise * draw();
  }
  return spectrum;
}

Complex nothing(double) {
  return 0.0;
}
/// A resonance at 50 Hz of half-power band 2 Hz.
Complex pole(double f) {
  return 1.0 / Complex(f - 50.0, -1.0);
}
Complex curve(double f) {
  return Complex(2.0, 1.0) + f * Complex(0.03, -0.02) + f * f * Complex(-2e-4, 1e-4);
}

double largest_error(const LocalModel& model, long output, const std::function<Complex(double)>& truth) {
  double worst = 0.0;
  for (long i = 0; i < model.frequency_hz.size(); ++i)
    worst = std::max(worst, std::abs(model.value(i, output) - truth(model.frequency_hz[i])) /
                                std::abs(truth(model.frequency_hz[i])));
  return worst;
}

// What the model class holds is met but for rounding: sums of squares leave half the digits at worst, and the
// pole's window spans powers of 100 in magnitude.
TEST(LocalModel, ARationalFunctionAndItsTransientAreMetExactly) {
  const auto second = [](double f) { return 0.3 + (0.2 - 0.01 * f) * pole(f); };
  const auto leak = [](double f) { return (3.0 + 0.1 * f) * pole(f); };
  const auto spectrum = record(0.1, 1000, {pole, second}, leak, 0.0, 1);
  const LocalModel model = local_model({spectrum}, 100.0, {0.8, 2, 1, LocalForm::rational});
  EXPECT_EQ(model.frequency_hz.size(), 124);  // 0.8 .. 99.2 Hz
  EXPECT_LT(largest_error(model, 0, pole), 1e-6);
  EXPECT_LT(largest_error(model, 1, second), 1e-6);
}

TEST(LocalModel, APolynomialModelMeetsAParabolaAndItsTransientExactly) {
  const auto leak = [](double f) { return Complex(5.0, -0.1 * f); };
  const auto spectrum = record(0.1, 1000, {curve}, leak, 0.0, 2);
  const LocalModel model = local_model({spectrum}, 100.0, {0.8, 2, 1, LocalForm::polynomial});
  EXPECT_LT(largest_error(model, 0, curve), 1e-9);
}

// Records of different length and transients share one function.
TEST(LocalModel, RecordsOfDifferentLengthAreTakenTogether) {
  const auto leak = [](double f) { return 5.0 * pole(f); };
  const auto other = [](double f) { return Complex(0.0, -2.0) * pole(f); };
  const std::vector<RecordSpectrum> both = {record(0.1, 1000, {pole}, leak, 0.0, 3),
                                            record(0.13, 770, {pole}, other, 0.0, 4)};
  EXPECT_LT(largest_error(local_model(both, 100.0, {0.8, 2, 1, LocalForm::rational}), 0, pole), 1e-6);
  // And halve the noise's power.
  const auto noisy = [&](const std::vector<RecordSpectrum>& records) {
    return local_model(records, 100.0, {0.8, 2, 1, LocalForm::polynomial}).sigma.mean();
  };
  const auto first = record(0.1, 1000, {curve}, nothing, 0.1, 5);
  const auto second = record(0.1, 1000, {curve}, nothing, 0.1, 6);
  EXPECT_NEAR(noisy({first, second}) / noisy({first}), std::sqrt(0.5), 0.03);
}

// z = error/sigma of real and imaginary part. 2 x 2 x 1200 lines, of which about every second is independent:
// its mean square is 1 within 0.06 at three sigma; the rest is the scatter of sigma itself (|X|^2 taken as
// constant where that is of second order).
TEST(LocalModel, ErrorsAreThoseThatSigmaTells) {
  for (const auto form : {LocalForm::rational, LocalForm::polynomial})
    for (const double noise : {1e-3, 0.1, 3.0}) {
      double square = 0.0, power = 0.0;
      long count = 0;
      for (unsigned seed = 1; seed <= 4; ++seed) {
        const auto spectrum = record(
            0.05, 4000, {curve, [](double f) { return 1.0 / curve(f); }},
            [](double f) { return 0.5 * curve(f); }, noise, 100 * seed);
        const LocalModel model = local_model({spectrum}, 200.0, {0.4, 2, 1, form});
        for (long i = 0; i < model.frequency_hz.size(); ++i) {
          const double f = model.frequency_hz[i];
          square += 0.5 * std::norm((model.value(i, 0) - curve(f)) / model.sigma(i, 0)) +
                    0.5 * std::norm((model.value(i, 1) - 1.0 / curve(f)) / model.sigma(i, 1));
          power += model.noise_power.row(i).sum();
          count += 2;
        }
      }
      EXPECT_NEAR(square / static_cast<double>(count), 1.0, 0.15) << noise;
      // A denominator that meets nothing but noise takes some 5 % more of it than its two unknowns' share.
      EXPECT_NEAR(power / static_cast<double>(count) / (noise * noise), 1.0, 0.08) << noise;
    }
}

TEST(LocalModel, CoherenceIsTheShareOfTheOutputThatTheInputExplains) {
  const auto constant = [](double) { return Complex(2.0, 0.0); };
  const auto spectrum = record(0.05, 4000, {constant}, nothing, 1.0, 9);
  const LocalModel model = local_model({spectrum}, 200.0, {0.4, 2, 1, LocalForm::rational});
  EXPECT_NEAR(model.coherence.mean(), 4.0 / 5.0, 0.02);  // |H|^2 S_xx = 4, noise 1; scatter over 500 windows
  EXPECT_NEAR(model.input_power.mean(), 1.0, 0.05);
}

TEST(LocalModel, AStrideLeavesLinesOutAndChangesNoOther) {
  const auto spectrum = record(0.1, 1000, {pole}, nothing, 0.01, 10);
  const LocalModel all = local_model({spectrum}, 100.0, {0.8, 2, 1, LocalForm::rational});
  const LocalModel some = local_model({spectrum}, 100.0, {0.8, 2, 3, LocalForm::rational});
  ASSERT_EQ(some.frequency_hz.size(), all.frequency_hz.size() / 3);
  for (long i = 0; i < some.frequency_hz.size(); ++i)
    EXPECT_EQ(some.value(i, 0), all.value(3 * i + 2, 0)) << some.frequency_hz[i];
}

// A smooth input (a hit) cannot be told from a transient; no input is no function.
TEST(LocalModel, LinesWithoutASeparableInputAreLeftOut) {
  auto spectrum = record(0.1, 1000, {pole}, nothing, 0.0, 11);
  spectrum.lines.block(400, 0, 200, 1).setOnes();
  spectrum.lines.block(700, 0, 200, 1).setZero();
  const LocalModel model = local_model({spectrum}, 100.0, {0.8, 2, 1, LocalForm::rational});
  for (const double f : model.frequency_hz) {
    EXPECT_FALSE(f > 42.5 && f < 57.5) << f;
    EXPECT_FALSE(f > 72.5 && f < 87.5) << f;
  }
  EXPECT_GT(model.frequency_hz.size(), 70);
}

TEST(LocalModel, WrongOptionsAndRecordsAreRefused) {
  const auto good = record(0.1, 1000, {pole}, nothing, 0.0, 12);
  const auto message = [&](const std::vector<RecordSpectrum>& records, const LocalModelOptions& options,
                           double highest = 100.0) -> std::string {
    try {
      local_model(records, highest, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const LocalModelOptions sound{0.8, 2, 1, LocalForm::rational};
  EXPECT_EQ(message({good}, sound), "no error");
  EXPECT_THAT(message({}, sound), HasSubstr("at least one record"));
  for (const double spacing : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_THAT(message({good}, {spacing, 2, 1, LocalForm::rational}), HasSubstr("line spacing"));
  EXPECT_THAT(message({good}, {0.8, 0, 1, LocalForm::rational}), HasSubstr("reach"));
  EXPECT_THAT(message({good}, {0.8, 2, 0, LocalForm::rational}), HasSubstr("stride"));
  EXPECT_THAT(message({good}, {0.1, 2, 1, LocalForm::rational}), HasSubstr("5.0 lines of a record"));
  EXPECT_THAT(message({good}, {30.0, 2, 1, LocalForm::rational}), HasSubstr("fewer than a window's 5"));
  EXPECT_THAT(message({record(0.1, 1000, {}, nothing, 0.0, 1)}, sound), HasSubstr("got 1 channels"));
  EXPECT_THAT(message({good, record(0.1, 1000, {pole, pole}, nothing, 0.0, 1)}, sound),
              HasSubstr("a record of 3 channels among others of 2"));
}

}  // namespace
}  // namespace struna::ident
