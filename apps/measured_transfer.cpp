#include "apps/measured_transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/repeated_records.hpp"
#include "ident/fixture.hpp"
#include "ident/half_power.hpp"
#include "ident/leakage.hpp"
#include "ident/noise_floor.hpp"
#include "ident/resonance_search.hpp"
#include "ident/transfer_function_file.hpp"

namespace struna::apps {
namespace {

/// Of the loss factor. Peaks are read off roughly, narrow ones as three lines wide, which is told.
constexpr double warned_doubt = 0.055;
constexpr double warned_lowering = 0.075;  // below, standard errors hold it
constexpr long least_lines = 20;           // of a function in which peaks are looked for

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
      if (measured.estimate.input.quantity == ident::Quantity::displacement)
        text += "; displacement may have met its noise floor there";
    }
    warnings.push_back(text);
  }
}

void warn_of_few_averages(const ident::TransferEstimate& estimate, std::vector<std::string>& warnings) {
  if (estimate.effective_averages > 1.01 && estimate.effective_averages < 5.0)
    warnings.push_back(fmt::format(
        "only {:.1f} effective averages: coherence reads high (by up to {:.2f}) and sigma scatters",
        estimate.effective_averages, 1.0 / estimate.effective_averages));
  else if (estimate.effective_averages > 0.0 && estimate.effective_averages <= 1.01)
    warnings.push_back(
        "one average only: coherence and sigma cannot be told; a coarser resolution, a longer record or "
        "repeats can tell them");
}

/// A band that was asked for further up than the records go.
void warn_of_cut_band(const Band& band, const ident::TransferFunction& all,
                      std::vector<std::string>& warnings) {
  const double top = all.frequency_hz[all.lines() - 1];
  const double next = all.lines() > 1 ? 2.0 * top - all.frequency_hz[all.lines() - 2] : top;
  if (band.hi_hz > next * (1.0 + 1e-9))
    warnings.push_back(fmt::format(
        "the band up to {:g} Hz ends at {:.6g} Hz: there are no lines beyond half the sample rate",
        band.hi_hz, top));
}

/// Between the lines, as peaks themselves are told by lines only.
double seen_half_power_band_hz(const ident::TransferFunction& form, const ident::Pole& peak) {
  const double f = peak.natural_frequency_hz, read_off = ident::bandwidth_hz(peak), reach = 3.0 * read_off;
  if (((form.frequency_hz.array() - f).abs() <= reach).count() < 3) return read_off;  // lines left out
  const ident::Mode mode = ident::fit_half_power(form, f, f - reach, f + reach, fem::Damping::structural);
  const double width = mode.upper_half_power_hz - mode.lower_half_power_hz;
  return std::isnan(width) ? read_off : width;
}

/// "81.2 Hz (by 8 %), 131 Hz (by 21 %) and 3 more"
std::string some_of(const std::vector<std::string>& places) {
  const std::size_t shown = std::min<std::size_t>(places.size(), 5);
  return fmt::format("{}{}",
                     fmt::join(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                     places.size() > shown ? fmt::format(" and {} more", places.size() - shown) : "");
}

/// Resonances whose peak leakage lowers, those that it widens beyond what can be taken out of their damping,
/// and those narrower than a line of the record.
void warn_of_few_lines(const ident::TransferEstimate& estimate, const ident::TransferFunction& tf,
                       std::vector<std::string>& warnings) {
  using ident::EstimateMethod;
  const bool welch = estimate.method == EstimateMethod::welch;
  if ((welch && estimate.window != ident::Window::hann) || tf.lines() < least_lines) return;
  // Unknown leakage is taken for that of the other averages.
  const double leakage = std::isnan(tf.leakage_hz) ? estimate.independent_line_hz : tf.leakage_hz;
  std::vector<std::string> lowered, widened, narrow;
  const ident::TransferFunction form =
      ident::to_circle_form(ident::with_noise_floor(tf), fem::Damping::structural);
  for (const ident::Pole& pole : ident::find_peaks(form)) {
    const double width = seen_half_power_band_hz(form, pole);
    const std::string at = fmt::format("{:.4g} Hz", pole.natural_frequency_hz);
    const double widening = ident::leakage_widening(width, leakage);
    if (const double lower = ident::leakage_lowering(width, leakage); lower > warned_lowering)
      lowered.push_back(
          fmt::format("{} (by {:.0f} %{})", at, 100.0 * lower, widening < 1.0 ? "" : " or more"));
    if (ident::leakage_doubt * widening > warned_doubt) widened.push_back(at);
    if (leakage == 0.0 && width < estimate.independent_line_hz) narrow.push_back(at);
  }
  if (!lowered.empty())
    warnings.push_back(fmt::format(
        "few lines of {:.3g} Hz in the half-power band: leakage lowers the resonance at {}{}; {}",
        estimate.independent_line_hz, some_of(lowered),
        widened.empty()
            ? ""
            : fmt::format(" and widens it, of which damping may keep the half at {}", some_of(widened)),
        welch ? "use --estimator local, a finer resolution or longer records" : "record for longer"));
  if (!narrow.empty())
    warnings.push_back(fmt::format(
        "narrower in the half-power band than a line of {:.3g} Hz at {}: damping is uncertain; {}",
        estimate.independent_line_hz, some_of(narrow),
        estimate.method == EstimateMethod::periodic ? "use a longer period" : "record for longer"));
}

}  // namespace

ident::TransferFunction in_band_and_form(ident::TransferFunction function, const TransferSettings& settings) {
  if (settings.band) function = ident::restrict_band(function, settings.band->lo_hz, settings.band->hi_hz);
  if (!settings.fixture.empty()) {
    const ident::TransferFunction empty = ident::read_transfer_function(settings.fixture);
    function =
        blaming({settings.fixture}, [&] { return ident::without_fixture(std::move(function), empty); });
  }
  if (!settings.clamp_mass.empty()) function = ident::without_mass(std::move(function), settings.clamp_mass);
  if (settings.form) function = ident::convert(function, *settings.form);
  return function;
}

MeasuredTransfer measure_transfer(const std::vector<std::string>& records, const std::string& input,
                                  const std::vector<std::string>& outputs,
                                  const std::map<std::string, ident::ChannelCorrection>& corrections,
                                  const TransferSettings& settings) {
  refuse_repeated_records(records);
  return examined(
      ident::estimate_transfer(records, input, outputs,
                               {settings.method, settings.estimator, settings.welch, settings.drive_signal},
                               corrections),
      settings);
}

MeasuredTransfer examined(ident::TransferEstimate estimate, const TransferSettings& settings) {
  MeasuredTransfer measured;
  measured.estimate = std::move(estimate);
  measured.warnings = measured.estimate.warnings;
  if (settings.band) warn_of_cut_band(*settings.band, measured.estimate.function, measured.warnings);
  measured.function = in_band_and_form(measured.estimate.function, settings);
  warn_of_few_averages(measured.estimate, measured.warnings);
  warn_of_low_coherence(measured, measured.warnings);
  warn_of_few_lines(measured.estimate, measured.function, measured.warnings);
  return measured;
}

std::vector<std::pair<std::string, std::string>> transfer_settings_shown(const MeasuredTransfer& measured) {
  const ident::TransferEstimate& estimate = measured.estimate;
  const ident::TransferFunction& tf = measured.function;
  const bool welch = estimate.method == ident::EstimateMethod::welch;
  std::vector<std::pair<std::string, std::string>> shown{
      {"estimator",
       (welch ? ident::to_string(estimate.ratio) + ", " : "") + ident::to_string(estimate.method)},
      {"chosen because", estimate.reason}};
  if (!estimate.drive_signal.empty()) shown.emplace_back("drive signal", estimate.drive_signal);
  if (welch) shown.emplace_back("window", ident::to_string(estimate.window));
  shown.emplace_back("resolution", fmt::format("{:.6g} Hz", estimate.resolution_hz));
  if (estimate.effective_averages > 0.0) {
    shown.emplace_back(welch ? "segments" : "periods", fmt::format("{:.0f}", estimate.segments));
    shown.emplace_back("effective averages", fmt::format("{:.1f}", estimate.effective_averages));
  } else {
    shown.emplace_back("records", fmt::format("{:.0f}", estimate.segments));
  }
  shown.emplace_back("sample rate", fmt::format("{:.6g} Hz", 1.0 / estimate.sample_interval));
  shown.emplace_back("band", fmt::format("{:.6g} to {:.6g} Hz, {} lines", tf.frequency_hz[0],
                                         tf.frequency_hz[tf.lines() - 1], tf.lines()));
  if (tf.leakage_hz > 0.0)
    shown.emplace_back("leakage",
                       fmt::format("of Hann lines {:.6g} Hz apart, taken out of the damping by struna modes",
                                   tf.leakage_hz));
  if (tf.exponential_decay > 0.0)
    shown.emplace_back(
        "exponential decay",
        fmt::format("{:.6g} 1/s, taken out of the damping by struna modes", tf.exponential_decay));
  return shown;
}

}  // namespace struna::apps
