#include "apps/simulated_transfer.hpp"

#include <cmath>
#include <numbers>
#include <variant>

#include "apps/predict.hpp"

namespace struna::apps {
namespace {

/// A record cut off earlier (an interrupted run) has no spectra worth drawing.
constexpr long fewest_samples = 256;

ident::Spectra hann_spectra(const ident::Record& record, const std::vector<std::string>& outputs) {
  ident::WelchOptions options;
  options.window = ident::Window::hann;
  return ident::welch_spectra(record, record.channels.front().name, outputs, options);
}

Band motion_band(const ident::Record& record) {
  if (record.samples.rows() < fewest_samples) return {};
  // The motion is read as its own output, so that a record without any other channel will do.
  ident::Record motion = record;
  motion.channels = {record.channels.front(), record.channels.front()};
  motion.channels.back().name += " again";
  motion.samples = record.samples.col(0).replicate(1, 2);
  const ident::Spectra spectra = hann_spectra(motion, {motion.channels.back().name});
  Eigen::ArrayXd density = spectra.input_auto.array();
  if (record.channels.front().quantity == ident::Quantity::displacement)
    density *= (2.0 * std::numbers::pi * spectra.frequency_hz.array()).pow(4);
  const double least = 0.1 * density.maxCoeff();
  Band band;
  for (long i = 1; i < density.size(); ++i) {
    if (!(density[i] >= least) || density[i] == 0.0) continue;
    if (band.lo_hz == 0.0) band.lo_hz = spectra.frequency_hz[i];
    band.hi_hz = spectra.frequency_hz[i];
  }
  return band;
}

}  // namespace

Band excited_band(const fem::Scene& scene, const ident::Record& record) {
  const fem::Excitation& excitation = scene.simulation->excitation;
  switch (excitation.kind) {
    case fem::Excitation::Kind::sine:
      return {};
    case fem::Excitation::Kind::record:
      return motion_band(record);
    default:
      return {excitation.band_lo_hz, excitation.band_hi_hz};
  }
}

RecordTransfer record_transfer(const ident::Record& record, const Band& band) {
  RecordTransfer transfer;
  std::vector<std::string> outputs;
  for (std::size_t k = 1; k < record.channels.size(); ++k) {
    const auto signal = record.samples.col(static_cast<long>(k)).array();
    const bool moves = (signal != signal[0]).any();
    (moves ? outputs : transfer.at_rest).push_back(record.channels[k].name);
  }
  if (outputs.empty() || record.samples.rows() < fewest_samples) return transfer;
  transfer.spectra = hann_spectra(record, outputs);
  // A band narrower than some lines (a sine, a record of one) has no function to draw.
  if (band.hi_hz - band.lo_hz < 4.0 * transfer.spectra.resolution_hz) return transfer;
  transfer.band = band;
  // A sweep is one segment without a taper, which would hide the band's ends: they pass in a moment.
  const ident::Spectra spectra = ident::welch_spectra(record, record.channels.front().name, outputs, {});
  const auto estimate = [&](ident::Estimator estimator) {
    return ident::restrict_band(ident::estimate_transfer_function(spectra, estimator), band.lo_hz,
                                band.hi_hz);
  };
  transfer.function = estimate(ident::Estimator::h1);
  if (spectra.segments > 1.0) transfer.amplitude_ratio = estimate(ident::Estimator::amplitude_ratio);
  return transfer;
}

std::optional<ident::TransferFunction> without_contact(const fem::Scene& scene,
                                                       const Eigen::VectorXd& frequency_hz) {
  const std::string body = std::visit([](const auto& at) { return at.body; }, scene.measurement->at);
  if (frequency_hz.size() == 0 || !fem::is_on_linear_path(scene, body)) return std::nullopt;
  return predict(scene, fem::body_named(scene, body).material.damping, frequency_hz, ident::FrfKind::unknown);
}

}  // namespace struna::apps
