#include "apps/measured_transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace struna::apps {
namespace {

/// Share of the lines at which a condition holds.
template <class Condition>
double share(const Eigen::VectorXd& values, Condition condition) {
  return static_cast<double>(std::count_if(values.begin(), values.end(), condition)) /
         static_cast<double>(values.size());
}

/// Where, from the top, the coherence stays low: the highest line at which the median of nine reaches 0.8.
double last_coherent_hz(const ident::TransferFunction& tf, const Eigen::VectorXd& coherence) {
  constexpr long around = 4;
  for (long i = tf.lines() - 1 - around; i >= around; --i) {
    Eigen::VectorXd near = coherence.segment(i - around, 2 * around + 1);
    std::nth_element(near.begin(), near.begin() + around, near.end());
    if (near[around] >= 0.8) return tf.frequency_hz[i + around];
  }
  return 0.0;
}

void warn_of_low_coherence(const MeasuredTransfer& measured, std::vector<std::string>& warnings) {
  const ident::TransferFunction& tf = measured.function;
  for (const auto& output : tf.outputs) {
    if (output.coherence.size() == 0) continue;
    const double low = share(output.coherence, [](double c) { return c < 0.8; });
    if (low < 0.25) continue;
    const double top = last_coherent_hz(tf, output.coherence);
    std::string text = fmt::format(
        "{}: coherence is below 0.8 at {:.0f} % of the lines (noise, leakage, or a nonlinear path such as "
        "contact)",
        output.name, 100.0 * low);
    const double lowest = tf.frequency_hz[0];
    const double highest = tf.frequency_hz[tf.lines() - 1];
    if (top > lowest + 0.1 * (highest - lowest) && top < highest - 0.1 * (highest - lowest)) {
      text += fmt::format("; hardly a line above {:.4g} Hz is coherent: narrow the band (--band)", top);
      // Displacement falls as 1/omega^2, so its sensor's noise is what is left at the top of a band.
      if (measured.spectra.input.quantity == ident::Quantity::displacement)
        text += "; displacement may have met its noise floor there";
    }
    warnings.push_back(text);
  }
}

void warn_of_few_averages(const ident::Spectra& spectra, std::vector<std::string>& warnings) {
  if (spectra.effective_averages > 1.01 && spectra.effective_averages < 5.0)
    warnings.push_back(fmt::format(
        "only {:.1f} effective averages: coherence reads high (by up to {:.2f}) and sigma scatters",
        spectra.effective_averages, 1.0 / spectra.effective_averages));
}

}  // namespace

MeasuredTransfer measure_transfer(const std::vector<std::string>& records, const std::string& input,
                                  const std::vector<std::string>& outputs,
                                  const std::map<std::string, ident::ChannelCorrection>& corrections,
                                  const TransferSettings& settings) {
  MeasuredTransfer measured;
  measured.spectra = ident::welch_spectra(records, input, outputs, settings.welch, corrections);
  measured.function = ident::estimate_transfer_function(measured.spectra, settings.estimator);
  if (settings.band)
    measured.function = ident::restrict_band(measured.function, settings.band->lo_hz, settings.band->hi_hz);
  if (settings.form) measured.function = ident::convert(measured.function, *settings.form);
  measured.warnings = measured.spectra.warnings;
  warn_of_few_averages(measured.spectra, measured.warnings);
  warn_of_low_coherence(measured, measured.warnings);
  return measured;
}

std::vector<std::pair<std::string, std::string>> transfer_settings_shown(const MeasuredTransfer& measured,
                                                                         const TransferSettings& settings) {
  const ident::Spectra& spectra = measured.spectra;
  const ident::TransferFunction& tf = measured.function;
  std::vector<std::pair<std::string, std::string>> shown{
      {"estimator", ident::to_string(settings.estimator)},
      {"window", ident::to_string(spectra.window)},
      {"resolution", fmt::format("{:.6g} Hz", spectra.resolution_hz)},
      {"segments", fmt::format("{:.0f}", spectra.segments)},
      {"effective averages", fmt::format("{:.1f}", spectra.effective_averages)},
      {"sample rate", fmt::format("{:.6g} Hz", 1.0 / spectra.sample_interval)},
      {"band", fmt::format("{:.6g} to {:.6g} Hz, {} lines", tf.frequency_hz[0],
                           tf.frequency_hz[tf.lines() - 1], tf.lines())},
  };
  if (spectra.exponential_decay > 0.0)
    shown.emplace_back(
        "exponential decay",
        fmt::format("{:.6g} 1/s, taken out of the damping by struna modes", spectra.exponential_decay));
  return shown;
}

}  // namespace struna::apps
