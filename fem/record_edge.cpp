#include "fem/record_edge.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace struna::fem {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr long reach = 10;    ///< samples on either side that the filter reaches
constexpr long context = 40;  ///< sound samples that speak about the first ones
constexpr int factors[] = {2, 3, 4, 5, 6, 8, 10, 12, 15, 16, 20, 25, 32, 40, 50, 64, 100, 128, 200};

/// Spectral lines above the noise floor, and the noise.
struct Spectrum {
  std::vector<double> omega;     ///< [rad/s]
  std::vector<double> variance;  ///< of each line
  double noise = 0.0;            ///< variance of a sample
};

/// Welch's estimate with the four-term Blackman-Harris window (F. J. Harris, Proc. IEEE 66 (1978) 51), whose
/// side lobes of -92 dB keep a displacement's steep spectrum apart from its noise.
Spectrum spectrum_of(const Eigen::VectorXd& samples, double interval) {
  constexpr long size = 256;
  Eigen::VectorXd taper(size);
  for (long i = 0; i < size; ++i) {
    const double p = two_pi * static_cast<double>(i) / size;
    taper[i] = 0.35875 - 0.48829 * std::cos(p) + 0.14128 * std::cos(2.0 * p) - 0.01168 * std::cos(3.0 * p);
  }
  Eigen::VectorXd power = Eigen::VectorXd::Zero(size / 2);
  Eigen::FFT<double> fft;
  long segments = 0;
  for (long at = reach; at + size <= samples.size() - reach; at += size / 2, ++segments) {
    const Eigen::VectorXd piece = samples.segment(at, size).cwiseProduct(taper);
    Eigen::VectorXcd transformed(size);
    fft.fwd(transformed, piece);
    power += transformed.head(size / 2).cwiseAbs2();
  }
  // Variance of a line: 2 |X|^2/(n sum w^2), half of that at zero frequency.
  power *= 2.0 / (static_cast<double>(segments * size) * taper.squaredNorm());
  power[0] *= 0.5;
  std::vector<double> sorted(power.data(), power.data() + power.size());
  std::sort(sorted.begin(), sorted.end());
  const double floor = sorted[sorted.size() / 10];
  Spectrum spectrum;
  spectrum.noise = floor * size / 2.0;
  for (long k = 0; k < size / 2; ++k) {
    if (power[k] < 3.0 * floor) continue;
    spectrum.omega.push_back(two_pi * static_cast<double>(k) / (static_cast<double>(size) * interval));
    spectrum.variance.push_back(power[k] - floor);
  }
  return spectrum;
}

/// Windowed sinc with unit sum that cuts at the new Nyquist frequency: taps -reach*factor .. reach*factor.
std::vector<double> resampling_filter(int factor, bool kaiser) {
  const long half = reach * factor;
  std::vector<double> taps;
  double sum = 0.0;
  for (long k = -half; k <= half; ++k) {
    const double x = static_cast<double>(k) / static_cast<double>(half);
    const double z = std::numbers::pi * static_cast<double>(k) / factor;
    const double window = kaiser ? std::cyl_bessel_i(0.0, 5.0 * std::sqrt(std::max(0.0, 1.0 - x * x)))
                                 : 0.54 + 0.46 * std::cos(std::numbers::pi * x);
    taps.push_back(window * (k == 0 ? 1.0 : std::sin(z) / z));
    sum += taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

/// Every sample's answer to exp(i omega t): rows samples, columns lines. The first `reach` samples hold only
/// what the filter saw from t = 0 on.
Eigen::MatrixXcd edge_response(const Spectrum& spectrum, double interval, int factor, bool kaiser) {
  const auto lines = static_cast<long>(spectrum.omega.size());
  const std::vector<double> taps = resampling_filter(factor, kaiser);
  Eigen::MatrixXcd response(reach + context, lines);
  for (long line = 0; line < lines; ++line) {
    const double omega = spectrum.omega[static_cast<std::size_t>(line)];
    for (long n = 0; n < reach + context; ++n) {
      const auto phase = std::polar(1.0, omega * static_cast<double>(n) * interval);
      response(n, line) = phase;
      if (n >= reach) continue;
      // Whole signal minus what zeros took the place of: t = n T - k T/factor < 0.
      for (long k = n * factor + 1; k <= reach * factor; ++k) {
        const double t = (static_cast<double>(n) - static_cast<double>(k) / factor) * interval;
        response(n, line) -= taps[static_cast<std::size_t>(k + reach * factor)] * std::polar(1.0, omega * t);
      }
    }
  }
  return response;
}

Eigen::MatrixXcd plain_response(const Spectrum& spectrum, double interval) {
  const auto lines = static_cast<long>(spectrum.omega.size());
  Eigen::MatrixXcd response(reach + context, lines);
  for (long line = 0; line < lines; ++line) {
    for (long n = 0; n < reach + context; ++n) {
      response(n, line) =
          std::polar(1.0, spectrum.omega[static_cast<std::size_t>(line)] * static_cast<double>(n) * interval);
    }
  }
  return response;
}

Eigen::MatrixXd covariance(const Spectrum& spectrum, const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b) {
  const Eigen::Map<const Eigen::VectorXd> variance(spectrum.variance.data(),
                                                   static_cast<long>(spectrum.variance.size()));
  return (a * variance.asDiagonal() * b.adjoint()).real();
}

struct Hypothesis {
  double log_likelihood = -std::numeric_limits<double>::infinity();
  double chi_square = 0.0;
  Eigen::VectorXd mean;      ///< of the first samples
  double uncertainty = 0.0;  ///< largest standard deviation
};

Hypothesis weigh(const Spectrum& spectrum, const Eigen::MatrixXcd& seen, const Eigen::MatrixXcd& truth,
                 const Eigen::VectorXd& y) {
  Eigen::MatrixXd k = covariance(spectrum, seen, seen);
  k.diagonal().array() += spectrum.noise;
  const Eigen::LLT<Eigen::MatrixXd> factor(k);
  Hypothesis result;
  if (factor.info() != Eigen::Success) return result;
  const Eigen::VectorXd solved = factor.solve(y);
  result.chi_square = y.dot(solved);
  result.log_likelihood =
      -0.5 * result.chi_square - Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum();
  const Eigen::MatrixXcd first = truth.topRows(reach);
  const Eigen::MatrixXd cross = covariance(spectrum, first, seen);
  result.mean = cross * solved;
  const Eigen::MatrixXd left = covariance(spectrum, first, first) - cross * factor.solve(cross.transpose());
  result.uncertainty = std::sqrt(std::max(0.0, left.diagonal().maxCoeff()));
  return result;
}

/// Whether the bend of the first samples is far above that of the whole record.
bool starts_with_jump(const Eigen::VectorXd& x) {
  const long n = x.size();
  const Eigen::VectorXd bend = x.head(n - 2) - 2.0 * x.segment(1, n - 2) + x.tail(n - 2);
  const double usual = std::sqrt(bend.segment(20, n - 42).squaredNorm() / static_cast<double>(n - 42));
  return bend.head(4).cwiseAbs().maxCoeff() > 10.0 * usual;
}

}  // namespace

std::optional<RecordEdge> find_resampling_edge(const Eigen::VectorXd& samples, double sample_interval) {
  if (samples.size() < 512 || !starts_with_jump(samples)) return std::nullopt;
  const Spectrum spectrum = spectrum_of(samples, sample_interval);
  if (spectrum.omega.empty()) return std::nullopt;
  const Eigen::VectorXd y = samples.head(reach + context);
  const Eigen::MatrixXcd truth = plain_response(spectrum, sample_interval);
  Hypothesis best = weigh(spectrum, truth, truth, y);
  int best_factor = 0;
  for (const bool kaiser : {true, false}) {
    for (const int factor : factors) {
      Hypothesis tried = weigh(spectrum, edge_response(spectrum, sample_interval, factor, kaiser), truth, y);
      if (tried.log_likelihood <= best.log_likelihood) continue;
      best = std::move(tried);
      best_factor = factor;
    }
  }
  // Expected: as many as there are samples, plus or minus the root of twice that; the spectrum is an
  // estimate.
  if (best_factor == 0 || best.chi_square > 4.0 * static_cast<double>(reach + context)) return std::nullopt;
  return RecordEdge{best_factor, std::move(best.mean), best.uncertainty};
}

}  // namespace struna::fem
