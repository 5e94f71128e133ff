#include "apps/shaken_wire.hpp"

#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>

#include "fem/error.hpp"

namespace struna::apps {
namespace {

constexpr double rate = 2000.0;       ///< [Hz]
constexpr double highest_hz = 800.0;  ///< of a band

void add_noise(Eigen::Ref<Eigen::VectorXd> channel, double share, std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  const double sigma = share * std::sqrt(channel.squaredNorm() / static_cast<double>(channel.size()));
  for (double& value : channel) value += sigma * normal(engine);
}

}  // namespace

ShakenWire::ShakenWire() {
  const double diameter = 0.0032;
  const double area = 0.25 * std::numbers::pi * diameter * diameter;
  beam = {0.68, 120e9 * area * diameter * diameter / 16.0, 7650.0 * area};
}

std::vector<double> ShakenWire::natural_frequencies_hz(double up_to_hz) const {
  std::vector<double> frequencies;
  for (int mode = 1;; ++mode) {
    const double f = fem::natural_frequency_hz(beam, mode);
    if (f > up_to_hz) return frequencies;
    frequencies.push_back(f);
  }
}

ident::Record ShakenWire::record(double duration, double lo_hz, double hi_hz, const SensorNoise& noise,
                                 unsigned seed) const {
  if (!(duration > 0.0 && lo_hz > 0.0 && lo_hz < hi_hz && hi_hz <= highest_hz)) {
    throw Error(
        fmt::format("ShakenWire: a duration above 0 s and a band within 0 to {:g} Hz, got {:g} s, {:g} to "
                    "{:g} Hz",
                    highest_hz, duration, lo_hz, hi_hz));
  }
  const auto samples = static_cast<long>(std::lround(duration * rate));
  long period = 1;
  while (3 * period < 4 * samples) period *= 2;
  const double spacing = rate / static_cast<double>(period);

  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const auto half = static_cast<std::size_t>(period / 2 + 1);
  std::vector<std::complex<double>> motion(half), force(half);
  const double lines = (hi_hz - lo_hz) / spacing;
  const double size = static_cast<double>(period) / std::sqrt(4.0 * lines);
  for (auto k = static_cast<std::size_t>(std::ceil(lo_hz / spacing));
       k <= static_cast<std::size_t>(hi_hz / spacing); ++k) {
    const double f = spacing * static_cast<double>(k);
    const double omega = 2.0 * std::numbers::pi * f;
    const double re = normal(engine), im = normal(engine);
    motion[k] = -size / (omega * omega) * std::complex<double>(re, im);
    force[k] = motion[k] * fem::far_support_stiffness(beam, loss_factor, f);
  }

  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  ident::Record result;
  result.sample_interval = 1.0 / rate;
  result.channels = {{"displacement", ident::Quantity::displacement, 0.0},
                     {"force_y", ident::Quantity::force, 0.0}};
  result.samples.resize(samples, 2);
  std::vector<double> signal(static_cast<std::size_t>(period));
  for (long channel = 0; channel < 2; ++channel) {
    fft.inv(signal, channel == 0 ? motion : force, period);
    result.samples.col(channel) = Eigen::Map<const Eigen::VectorXd>(signal.data(), samples);
  }
  add_noise(result.samples.col(0), noise.displacement, engine);
  add_noise(result.samples.col(1), noise.force, engine);
  return result;
}

}  // namespace struna::apps
