#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "ident/resonance.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident::simulated {

/// A pole and its constant in each output, in circle form.
struct SimulatedMode {
  Pole pole;
  std::vector<std::complex<double>> constant;
};

inline Eigen::VectorXd lines(double lo_hz, double hi_hz, double step_hz) {
  return Eigen::VectorXd::LinSpaced(std::lround((hi_hz - lo_hz) / step_hz) + 1, lo_hz, hi_hz);
}

/// Sum of the modes' shares and a constant residual in each output, noise-free, in circle form of the kind
/// given.
inline TransferFunction function_of(const std::vector<SimulatedMode>& modes,
                                    const Eigen::VectorXd& frequency_hz, FrfKind kind,
                                    fem::Damping damping = fem::Damping::structural,
                                    const std::vector<std::complex<double>>& residual = {}) {
  TransferFunction tf;
  tf.frequency_hz = frequency_hz;
  for (std::size_t k = 0; k < modes.front().constant.size(); ++k) {
    TransferFunction::Output output;
    output.name = std::string("force_") + "xyz"[k];
    output.kind = kind;
    output.unit = unit_of(kind);
    output.value = Eigen::VectorXcd::Constant(frequency_hz.size(), residual.empty() ? 0.0 : residual[k]);
    for (long i = 0; i < frequency_hz.size(); ++i)
      for (const SimulatedMode& mode : modes)
        output.value(i) +=
            modal_share(mode.constant[k], mode.pole, 2.0 * std::numbers::pi * frequency_hz(i), damping);
    tf.outputs.push_back(std::move(output));
  }
  return tf;
}

/// Complex normal noise, sigma[k] in the real and in the imaginary part of output k; sigma is given with it.
inline void add_noise(TransferFunction& tf, const std::vector<double>& sigma, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (std::size_t k = 0; k < tf.outputs.size(); ++k) {
    auto& output = tf.outputs[k];
    for (long i = 0; i < tf.lines(); ++i) {
      const double re = normal(engine), im = normal(engine);
      output.value(i) += sigma[k] * std::complex<double>(re, im);
    }
    output.sigma = Eigen::VectorXd::Constant(tf.lines(), sigma[k]);
  }
}

/// The eight-mode set: accelerance of one input to three outputs, hysteretic, 0 to 1200 Hz in steps of 0.25
/// Hz, one close pair (three bandwidths). A published comparison of identification programs uses the same
/// set.
inline std::vector<SimulatedMode> eight_modes() {
  const double f[] = {22, 61, 118, 205, 340, 600, (600 + 1.5 * 4.8) / (1 - 1.5 * 0.01), 970};
  const double eta[] = {.050, .030, .020, .0125, .0075, .008, .010, .005};
  const double shape[3][8] = {{1, .9, 1.1, .8, 1.05, .95, 1, .85},
                              {.6, -.7, .9, -1.1, .5, -.8, .9, 1},
                              {-.8, .5, .7, .95, -1.15, .6, -.75, -.9}};
  std::vector<SimulatedMode> modes;
  for (int r = 0; r < 8; ++r) {
    SimulatedMode mode{{f[r], eta[r]}, {}};
    for (int k = 0; k < 3; ++k) mode.constant.push_back(shape[k][r] * shape[0][r]);
    modes.push_back(mode);
  }
  return modes;
}

/// The set as an accelerance with noise of standard deviation `level` of each output's rms.
inline TransferFunction eight_mode_set(double level, unsigned seed) {
  TransferFunction tf = function_of(eight_modes(), lines(0.0, 1200.0, 0.25), FrfKind::receptance);
  std::vector<double> sigma;
  for (auto& output : tf.outputs) {
    output.kind = FrfKind::accelerance;
    output.unit = unit_of(output.kind);
    for (long i = 0; i < tf.lines(); ++i)
      output.value(i) *= -std::pow(2.0 * std::numbers::pi * tf.frequency_hz(i), 2.0);
    sigma.push_back(level / std::numbers::sqrt2 *
                    std::sqrt(output.value.squaredNorm() / static_cast<double>(tf.lines())));
  }
  add_noise(tf, sigma, seed);
  return tf;
}

}  // namespace struna::ident::simulated
