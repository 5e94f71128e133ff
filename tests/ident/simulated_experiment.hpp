#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "ident/fft.hpp"
#include "ident/mode_identification.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/prediction_band.hpp"
#include "ident/transfer_estimate.hpp"
#include "simulated_modes.hpp"
#include "synthetic_wire.hpp"

/// A measurement of a curved wire whose truth is known, from its transfer functions on, many times over: how
/// often do the stated 95 % intervals hold the truth?
namespace struna::ident::simulated {

/// A share of intervals: how many held the truth, of how many.
struct Coverage {
  long held = 0;
  long all = 0;
  void count(double error, double sigma) {
    constexpr double normal_95 = 1.959964;
    held += std::abs(error) <= normal_95 * sigma ? 1 : 0;
    ++all;
  }
  double share() const { return static_cast<double>(held) / static_cast<double>(all); }
};

struct Experiment {
  synthetic::Wire wire;
  TransferFunction clean = {};            ///< three support forces over base motion
  std::vector<double> sigma = {};         ///< noise of each output
  std::vector<double> frequency_hz = {};  ///< true natural frequencies in the band
  fem::FrequencyLaw modulus{fem::FrequencyLaw::Kind::power, {1e11, 0.02, 100.0}, {}, {}, 0.0, 0.0};
  double loss_factor = 0.015;
  Eigen::VectorXd predicted_hz = {};  ///< lines of the prediction
};

/// Modes no two of which are nearer than two bandwidths, from 15 to 170 Hz; noise of 3 % of each output's
/// rms.
inline Experiment experiment() {
  const fem::Centreline curve =
      fem::spline_through({{0, 0, 0}, {0.2, 0.05, 0}, {0.4, 0, 0.08}, {0.6, -0.05, 0.1}}, 0.68);
  Experiment e{synthetic::wire(curve, 3, 60)};
  fem::Material& material = e.wire.model.body.material;
  material.youngs_modulus = e.modulus;
  material.loss_factor = fem::constant_law(e.loss_factor);
  e.clean.frequency_hz = lines(15.0, 170.0, 0.1);
  const Eigen::MatrixXcd response =
      fem::harmonic_response(e.wire.model, e.wire.drive, e.wire.measurement, e.clean.frequency_hz).response;
  for (long k = 0; k < response.cols(); ++k) {
    e.clean.outputs.push_back(
        {std::string("force_") + "yxz"[k], FrfKind::dynamic_stiffness, "N/m", response.col(k), {}, {}});
    e.sigma.push_back(0.03 / std::numbers::sqrt2 *
                      std::sqrt(response.col(k).squaredNorm() / static_cast<double>(response.rows())));
  }
  for (const double eigenvalue : e.wire.modes.eigenvalue) {
    const double f = fem::natural_frequency_hz(eigenvalue, e.modulus);
    if (f > 16.0 && f < 165.0) e.frequency_hz.push_back(f);
  }
  e.predicted_hz = lines(20.0, 160.0, 3.5);
  return e;
}

struct Coverages {
  Coverage frequency, loss_factor, modulus, modulus_law, prediction;
  long lost_or_added = 0;  ///< runs whose modes are not the true ones, one for one
};

/// What becomes of one measured function.
inline void add_function(const Experiment& e, const TransferFunction& tf, Coverages& coverage) {
  const ModeSet set = identify_modes(tf);
  if (set.modes.size() != e.frequency_hz.size()) {
    ++coverage.lost_or_added;
    return;
  }
  const double apparent = e.loss_factor / (1.0 - 0.5 * e.modulus.parameters[1]);  // of a rising modulus
  for (std::size_t r = 0; r < set.modes.size(); ++r) {
    const Mode& mode = set.modes[r];
    coverage.frequency.count(mode.natural_frequency_hz - e.frequency_hz[r], mode.natural_frequency_sigma);
    coverage.loss_factor.count(mode.loss_factor - apparent, mode.loss_factor_sigma);
  }
  FitOptions options;  // without allowance for a model that is wrong: this one is right
  options.modulus_floor = options.loss_factor_floor = 0.0;
  options.modulus_law = "power";
  options.loss_factor_law = "constant";
  const IdentifiedParameters identified =
      identify_parameters(set, e.wire.model, e.wire.drive, e.wire.measurement, options);
  for (Eigen::Index i = 0; i < identified.modulus.value.size(); ++i)
    coverage.modulus.count(identified.modulus.value[i] - e.modulus.at(identified.modulus.frequency_hz[i]),
                           identified.modulus.sigma[i]);
  const LawFit& law = identified.modulus.laws.front();
  for (const double f : {20.0, 60.0, 120.0, 160.0})
    coverage.modulus_law.count(law.law.at(f) - e.modulus.at(f), law_sigma(law, f));

  const auto response = [&](const fem::Model& model) {
    return fem::harmonic_response(model, e.wire.drive, e.wire.measurement, e.predicted_hz);
  };
  fem::Model predicting = e.wire.model;
  predicting.body.material = apply(identified, predicting.body.material);
  const Eigen::MatrixXcd truth = response(e.wire.model).response;
  const fem::HarmonicResponse prediction = response(predicting);
  const Eigen::MatrixXcd& predicted = prediction.response;
  const PredictionBand band = prediction_band(predicting, e.wire.drive, e.wire.measurement, prediction,
                                              fem::Damping::structural, identified);
  for (long i = 0; i < truth.rows(); ++i)
    for (long k = 0; k < truth.cols(); ++k)
      coverage.prediction.count(std::abs(predicted(i, k)) - std::abs(truth(i, k)),
                                band.magnitude_sigma(i, k));
}

inline void add_run(const Experiment& e, unsigned seed, Coverages& coverage) {
  TransferFunction tf = e.clean;
  add_noise(tf, e.sigma, seed);
  add_function(e, tf, coverage);
}

/// The same experiment through its records: random base motion, forces with noise of 3 % of their rms, of
/// which a part may be shared by all outputs.
struct RecordedExperiment {
  Experiment experiment;
  double duration = 60.0;      ///< [s]
  double sample_rate = 480.0;  ///< [Hz]
  double lo_hz = 12.0;         ///< excited
  double hi_hz = 178.0;
  Eigen::MatrixXcd response = {};  ///< lines of four times the duration from lo_hz on, by outputs
};

inline RecordedExperiment recorded_experiment(double duration) {
  RecordedExperiment r{experiment()};
  r.duration = duration;
  const double spacing = 0.25 / duration;
  const long first = std::lround(r.lo_hz / spacing), last = std::lround(r.hi_hz / spacing);
  const Eigen::VectorXd f = spacing * Eigen::VectorXd::LinSpaced(last - first + 1, static_cast<double>(first),
                                                                 static_cast<double>(last));
  const synthetic::Wire& wire = r.experiment.wire;
  r.response = fem::harmonic_response(wire.model, wire.drive, wire.measurement, f).response;
  return r;
}

/// Exact: cut from the steady response to periodic noise of four times the length. `correlation` of the
/// outputs' noise.
inline Record record_of(const RecordedExperiment& r, double correlation, unsigned seed) {
  const long samples = std::lround(r.duration * r.sample_rate), whole = 4 * samples;
  const double spacing = 0.25 / r.duration;
  const long first = std::lround(r.lo_hz / spacing);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXcd motion = Eigen::VectorXcd::Zero(whole / 2 + 1);
  for (long i = 0; i < r.response.rows(); ++i) {
    const double omega = 2.0 * std::numbers::pi * spacing * static_cast<double>(first + i);
    const double re = normal(engine), im = normal(engine);
    motion(first + i) = 1e9 * std::complex<double>(re, im) / (omega * omega);  // white acceleration
  }
  Record record;
  record.sample_interval = 1.0 / r.sample_rate;
  record.channels = {{"displacement", Quantity::displacement}};
  record.samples.resize(samples, 1 + r.response.cols());
  record.samples.col(0) = inverse_transform(motion, whole).segment(samples, samples);
  Eigen::VectorXd shared(samples);
  for (double& value : shared) value = normal(engine);
  for (long k = 0; k < r.response.cols(); ++k) {
    Eigen::VectorXcd force = Eigen::VectorXcd::Zero(whole / 2 + 1);
    force.segment(first, r.response.rows()) =
        motion.segment(first, r.response.rows()).cwiseProduct(r.response.col(k));
    auto column = record.samples.col(k + 1);
    column = inverse_transform(force, whole).segment(samples, samples);
    const double level = 0.03 * std::sqrt(column.squaredNorm() / static_cast<double>(samples));
    for (long i = 0; i < samples; ++i)
      column(i) +=
          level * (std::sqrt(correlation) * shared(i) + std::sqrt(1.0 - correlation) * normal(engine));
    record.channels.push_back(
        {r.experiment.clean.outputs[static_cast<std::size_t>(k)].name, Quantity::force});
  }
  return record;
}

inline void add_recorded_run(const RecordedExperiment& r, double correlation, unsigned seed,
                             Coverages& coverage) {
  std::vector<std::string> outputs;
  for (const auto& output : r.experiment.clean.outputs) outputs.push_back(output.name);
  const TransferEstimate estimate =
      estimate_transfer(record_of(r, correlation, seed), "displacement", outputs, {});
  add_function(r.experiment, restrict_band(estimate.function, 15.0, 170.0), coverage);
}

}  // namespace struna::ident::simulated
