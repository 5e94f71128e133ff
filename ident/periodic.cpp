#include "ident/periodic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"
#include "ident/fft.hpp"

namespace struna::ident {
namespace {

constexpr double settled = 4.0;         // times the power by which the last two periods differ
constexpr double least_change = 1e-10;  // of a period's power: rounding, and what no record shows
constexpr double excited = 30.0;        // times the noise power of the mean
constexpr double least_power = 1e-12;   // of the strongest line: rounding

/// Periods of a record, counted from its end, that are settled.
long settled_periods(const Eigen::MatrixXd& record, long period) {
  const long all = record.rows() / period;
  const auto difference = [&](long k, long channel) {
    const auto part = record.col(channel).segment(record.rows() - k * period, period);
    return (part - record.col(channel).tail(period)).squaredNorm();
  };
  for (long k = all; k > 2; --k) {
    bool steady = true;
    for (long c = 1; c < record.cols(); ++c)
      steady = steady && difference(k, c) <= settled * difference(2, c) +
                                                 least_change * record.col(c).tail(period).squaredNorm();
    if (steady) return k;
  }
  return std::min(all, 2L);
}

}  // namespace

PeriodicEstimate periodic_estimate(const std::vector<Eigen::MatrixXd>& records, long period,
                                   double sample_interval) {
  if (records.empty() || period < 4)
    throw Error(
        fmt::format("periodic_estimate: needs a record and a period of at least 4 samples, got {}", period));
  const long channels = records.front().cols(), lines = (period - 1) / 2;
  PeriodicEstimate estimate;
  std::vector<Eigen::MatrixXcd> spectra;
  Fft fft(period);
  Eigen::MatrixXcd mean = Eigen::MatrixXcd::Zero(lines, channels);
  for (const Eigen::MatrixXd& record : records) {
    if (record.rows() < 2 * period)
      throw Error(fmt::format("periodic_estimate: {} samples are fewer than two periods of {}", record.rows(),
                              period));
    const long used = settled_periods(record, period);
    estimate.settling += record.rows() / period - used;
    for (long k = used; k > 0; --k) {
      Eigen::MatrixXcd& spectrum = spectra.emplace_back(lines, channels);
      for (long c = 0; c < channels; ++c) {
        fft.input() = record.col(c).segment(record.rows() - k * period, period);
        spectrum.col(c) = fft.transform().segment(1, lines);
      }
      mean += spectrum;
    }
  }
  estimate.periods = static_cast<long>(spectra.size());
  const double count = static_cast<double>(spectra.size());
  mean /= count;

  // Scatter of a single period: of the input about its mean, of the outputs about what the input explains.
  Eigen::MatrixXcd value(lines, channels - 1);
  for (long c = 1; c < channels; ++c) value.col(c - 1) = mean.col(c).cwiseQuotient(mean.col(0));
  Eigen::VectorXd input_scatter = Eigen::VectorXd::Zero(lines);
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(lines, channels - 1);
  for (const Eigen::MatrixXcd& spectrum : spectra) {
    input_scatter += (spectrum.col(0) - mean.col(0)).cwiseAbs2() / (count - 1.0);
    for (long c = 1; c < channels; ++c)
      scatter.col(c - 1) +=
          (spectrum.col(c) - value.col(c - 1).cwiseProduct(spectrum.col(0))).cwiseAbs2() / (count - 1.0);
  }
  const Eigen::VectorXd power = mean.col(0).cwiseAbs2();
  const double least = least_power * power.maxCoeff();
  Eigen::VectorXd sorted = input_scatter;
  std::nth_element(sorted.begin(), sorted.begin() + lines / 2, sorted.end());
  std::vector<long> kept;
  for (long i = 0; i < lines; ++i)
    if (power[i] > least && power[i] > excited * std::max(input_scatter[i], sorted[lines / 2]) / count)
      kept.push_back(i);
  estimate.frequency_hz = Eigen::VectorXd::LinSpaced(lines, 1.0, static_cast<double>(lines))(kept) /
                          (static_cast<double>(period) * sample_interval);
  estimate.value = value(kept, Eigen::all);
  estimate.sigma =
      (0.5 / count * (power.cwiseInverse().asDiagonal() * scatter)).cwiseSqrt()(kept, Eigen::all);
  const Eigen::MatrixXd signal = power.asDiagonal() * value.cwiseAbs2();
  estimate.coherence = signal.cwiseQuotient(signal + scatter)(kept, Eigen::all);
  return estimate;
}

}  // namespace struna::ident
