#pragma once

#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "ident/fft.hpp"
#include "ident/record.hpp"
#include "tests/ident/simulated_modes.hpp"

namespace struna::ident::simulated {

/// Accelerance -omega^2 sum A/(omega_r^2 (1 + i eta) - omega^2) of hysteretic modes at one frequency.
inline std::complex<double> accelerance(const std::vector<SimulatedMode>& modes, std::size_t output,
                                        double frequency_hz) {
  const double omega = 2.0 * std::numbers::pi * frequency_hz;
  std::complex<double> sum = 0.0;
  for (const SimulatedMode& mode : modes) {
    const double natural = 2.0 * std::numbers::pi * mode.pole.natural_frequency_hz;
    sum += mode.constant[output] /
           (natural * natural * std::complex<double>(1.0, mode.pole.loss_factor) - omega * omega);
  }
  return -omega * omega * sum;
}

/// A record of white force and the accelerations it causes, `noise` of each one's rms added to it. Exact: the
/// response to noise of four times the length, periodic, from which the record is cut, so that nothing in it
/// repeats itself and both its ends find the structure moving.
inline Record record_of(const std::vector<SimulatedMode>& modes, double duration, double sample_rate,
                        double noise, unsigned seed) {
  const long samples = std::lround(duration * sample_rate), whole = 4 * samples;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Fft fft(whole);
  for (double& value : fft.input()) value = normal(engine);
  const Eigen::VectorXd force = fft.input();
  const Eigen::VectorXcd lines = fft.transform();
  Record record;
  record.sample_interval = 1.0 / sample_rate;
  record.channels = {{"force", Quantity::force}};
  record.samples.resize(samples, 1 + static_cast<long>(modes.front().constant.size()));
  record.samples.col(0) = force.segment(samples, samples);
  for (std::size_t k = 0; k < modes.front().constant.size(); ++k) {
    Eigen::VectorXcd response = lines;
    for (long i = 0; i < lines.size(); ++i)
      response[i] *= accelerance(modes, k, static_cast<double>(i) * sample_rate / static_cast<double>(whole));
    response[lines.size() - 1] = 0.0;
    auto column = record.samples.col(static_cast<long>(k) + 1);
    column = inverse_transform(response, whole).segment(samples, samples);
    const double level = noise * std::sqrt(column.squaredNorm() / static_cast<double>(samples));
    for (double& value : column) value += level * normal(engine);
    record.channels.push_back({std::string("acceleration_") + "xyz"[k], Quantity::acceleration});
  }
  return record;
}

}  // namespace struna::ident::simulated
