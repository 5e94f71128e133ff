#include "ident/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "fem/error.hpp"
#include "ident/atomic_file.hpp"
#include "ident/modal_assurance.hpp"
#include "ident/noise_floor.hpp"

namespace struna::ident {
namespace {

using Output = TransferFunction::Output;

// A peak stands by both above the higher saddle beside it: noise of standard deviation sigma alone, on lines
// without signal, tops out near 4 sigma and falls to nothing.
constexpr double peak_prominence_db = 6.0;
constexpr double shallow_prominence_db = 0.5;  // of a predicted peak that a measured one may be set against
constexpr double peak_prominence_sigma = 5.0;  // of the top's and the saddle's together

double decibel(double ratio) {
  return 20.0 * std::log10(ratio);
}

/// The predicted output as a function of its own in the measured one's form.
TransferFunction predicted_alone(const TransferFunction& predicted, const Output& output,
                                 const Output& measured) {
  TransferFunction alone;
  alone.frequency_hz = predicted.frequency_hz;
  alone.outputs = {output};
  if (output.kind == measured.kind) {
    if (output.kind != FrfKind::unknown || output.unit == measured.unit) return alone;
    throw Error(fmt::format("compare: {}: measured in [{}], predicted in [{}], and neither form is known",
                            output.name, measured.unit, output.unit));
  }
  try {
    return convert(alone, measured.kind);
  } catch (const Error& error) {
    throw Error(fmt::format("compare: {}: measured as {}, predicted as {}: {}", output.name,
                            to_string(measured.kind), to_string(output.kind), error.reason()));
  }
}

/// Value at f, magnitude and phase linear between the lines beside it. f within the lines.
std::complex<double> interpolate(const TransferFunction& tf, double f_hz) {
  const Eigen::VectorXd& f = tf.frequency_hz;
  const Eigen::VectorXcd& value = tf.outputs.front().value;
  const Eigen::Index above = std::lower_bound(f.begin(), f.end(), f_hz) - f.begin();
  const Eigen::Index k = std::min(std::max<Eigen::Index>(above, 1), f.size() - 1);
  if (f.size() == 1) return value[0];
  const double t = std::clamp((f_hz - f[k - 1]) / (f[k] - f[k - 1]), 0.0, 1.0);
  // The written digits of two files may differ in the last: a line that is met within 1e-6 of the spacing is
  // that line.
  if (t < 1e-6) return value[k - 1];
  if (t > 1.0 - 1e-6) return value[k];
  const double magnitude = (1.0 - t) * std::abs(value[k - 1]) + t * std::abs(value[k]);
  const double step = std::arg(value[k] * std::conj(value[k - 1]));  // the short way round
  return std::polar(magnitude, std::arg(value[k - 1]) + t * step);
}

struct Peak {
  double frequency_hz = 0.0;
  double level_db = 0.0;
};

/// The line of the higher of the two saddles that part the maximum at k from higher ground (or from the end).
Eigen::Index higher_saddle(const Eigen::VectorXd& level, Eigen::Index k) {
  const auto lowest = [&](Eigen::Index step) {
    Eigen::Index saddle = k;
    for (Eigen::Index i = k + step; i >= 0 && i < level.size() && level[i] <= level[k]; i += step) {
      if (level[i] < level[saddle]) saddle = i;
    }
    return saddle;
  };
  const Eigen::Index left = lowest(-1);
  const Eigen::Index right = lowest(1);
  return level[left] > level[right] ? left : right;
}

/// Peaks with their tops from the parabola through three lines [dB]. With `sigma`, only those that fall to
/// the saddle by more than noise would.
std::vector<Peak> find_peaks(const Eigen::VectorXd& f, const Eigen::VectorXcd& value,
                             double least_prominence_db, const Eigen::VectorXd& sigma = {}) {
  std::vector<Peak> peaks;
  const Eigen::VectorXd magnitude = value.cwiseAbs();
  const Eigen::VectorXd level = magnitude.unaryExpr(&decibel);
  for (Eigen::Index k = 1; k + 1 < level.size(); ++k) {
    if (!(level[k] > level[k - 1] && level[k] >= level[k + 1])) continue;
    const Eigen::Index saddle = higher_saddle(level, k);
    if (level[k] - level[saddle] < least_prominence_db) continue;
    const double noise = sigma.size() > 0 ? sigma[k] + sigma[saddle] : 0.0;
    if (magnitude[k] - magnitude[saddle] < peak_prominence_sigma * noise) continue;
    const double curvature = level[k - 1] - 2.0 * level[k] + level[k + 1];
    const double half_slope = 0.5 * (level[k + 1] - level[k - 1]);
    const bool finite = std::isfinite(curvature) && curvature < 0.0;
    const double shift = finite ? std::clamp(-half_slope / curvature, -0.5, 0.5) : 0.0;
    const double spacing = shift > 0.0 ? f[k + 1] - f[k] : f[k] - f[k - 1];
    peaks.push_back({f[k] + shift * spacing, level[k] + (finite ? 0.5 * half_slope * shift : 0.0)});
  }
  return peaks;
}

std::vector<PeakDifference> compare_peaks(const std::vector<Peak>& measured,
                                          const std::vector<Peak>& predicted) {
  std::vector<PeakDifference> differences;
  for (const Peak& peak : measured) {
    const auto nearest =
        std::min_element(predicted.begin(), predicted.end(), [&](const Peak& a, const Peak& b) {
          return std::abs(std::log(a.frequency_hz / peak.frequency_hz)) <
                 std::abs(std::log(b.frequency_hz / peak.frequency_hz));
        });
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const bool any = nearest != predicted.end();
    differences.push_back({peak.frequency_hz, any ? nearest->frequency_hz : nan,
                           any ? nearest->level_db - peak.level_db : nan});
  }
  return differences;
}

/// The same over lines as modal assurance is over outputs; not defined (NaN) when either vanishes.
double frac(const Eigen::VectorXcd& measured, const Eigen::VectorXcd& predicted) {
  return modal_assurance(predicted, measured);
}

OutputComparison compare_output(const Eigen::VectorXd& f, const Output& measured,
                                const Eigen::VectorXcd& predicted) {
  OutputComparison result;
  result.output = measured.name;
  result.kind = measured.kind;
  result.lines = f.size();
  result.frac = frac(measured.value, predicted);
  result.noise_share = std::min(1.0, 2.0 * measured.sigma.squaredNorm() / measured.value.squaredNorm());
  result.measured_rms = std::sqrt(measured.value.squaredNorm() / static_cast<double>(f.size()));
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (Eigen::Index i = 0; i < f.size(); ++i) {
    const double m = std::abs(measured.value[i]);
    const double p = std::abs(predicted[i]);
    if (m == 0.0 || p == 0.0) continue;  // no logarithm
    const double difference = decibel(p / m);
    sum += difference;
    squares += difference * difference;
    result.largest_db = std::max(result.largest_db, std::abs(difference));
    count += 1.0;
  }
  result.mean_db = sum / count;
  result.log_magnitude_error_db = std::sqrt(squares / count);
  if (count == 0.0) result.largest_db = std::numeric_limits<double>::quiet_NaN();
  result.peaks = compare_peaks(find_peaks(f, measured.value, peak_prominence_db, measured.sigma),
                               find_peaks(f, predicted, shallow_prominence_db));
  return result;
}

double rms(const std::vector<double>& values) {
  double squares = 0.0;
  for (double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

std::string names_of(const TransferFunction& tf) {
  std::string names;
  for (const Output& output : tf.outputs) names += (names.empty() ? "" : ", ") + output.name;
  return names;
}

std::string number_or_nothing(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}

}  // namespace

Comparison compare(const TransferFunction& measured, const TransferFunction& predicted, double lo_hz,
                   double hi_hz) {
  if (measured.lines() == 0 || predicted.lines() == 0)
    throw Error("compare: at least one line each, got none");
  if ((lo_hz != 0.0 || hi_hz != 0.0) && !(lo_hz >= 0.0 && hi_hz > lo_hz)) {
    throw Error(fmt::format("compare: 0 <= lo < hi, got the band {} to {} Hz", lo_hz, hi_hz));
  }
  const auto find = [&](const std::string& name) {
    return std::find_if(predicted.outputs.begin(), predicted.outputs.end(),
                        [&](const Output& output) { return output.name == name; });
  };
  Comparison comparison;
  std::vector<const Output*> common;
  for (const Output& output : measured.outputs) {
    if (find(output.name) == predicted.outputs.end()) {
      comparison.not_compared.push_back(output.name);
    } else {
      common.push_back(&output);
    }
  }
  if (common.empty()) {
    throw Error(fmt::format("compare: no output in common: measured {}, predicted {}", names_of(measured),
                            names_of(predicted)));
  }
  const double slack = 1e-9 * measured.frequency_hz[measured.lines() - 1];
  double lo = std::max(measured.frequency_hz[0], predicted.frequency_hz[0] - slack);
  double hi = std::min(measured.frequency_hz[measured.lines() - 1],
                       predicted.frequency_hz[predicted.lines() - 1] + slack);
  if (hi_hz > 0.0) {
    lo = std::max(lo, lo_hz);
    hi = std::min(hi, hi_hz);
  }
  if (lo > hi) {
    throw Error(
        fmt::format("compare: no line in common: measured {:.6g} to {:.6g} Hz, predicted {:.6g} to {:.6g} Hz",
                    measured.frequency_hz[0], measured.frequency_hz[measured.lines() - 1],
                    predicted.frequency_hz[0], predicted.frequency_hz[predicted.lines() - 1]));
  }
  for (const Output* output : common) {
    // A conversion may have dropped a line at 0 Hz: the band is the converted one's.
    const TransferFunction alone = predicted_alone(predicted, *find(output->name), *output);
    TransferFunction lines = measured;
    lines.outputs = {*output};
    lines = with_noise_floor(restrict_band(lines, std::max(lo, alone.frequency_hz[0]), hi));
    Eigen::VectorXcd values(lines.lines());
    for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = interpolate(alone, lines.frequency_hz[i]);
    comparison.outputs.push_back(compare_output(lines.frequency_hz, lines.outputs.front(), values));
    comparison.lo_hz = lines.frequency_hz[0];
    comparison.hi_hz = lines.frequency_hz[lines.lines() - 1];
  }
  return comparison;
}

bool is_defined(const OutputComparison& output) {
  return std::isfinite(output.frac) && std::isfinite(output.log_magnitude_error_db);
}

double mean_level_error_db(const Comparison& comparison) {
  double sum = 0.0;
  double count = 0.0;
  for (const OutputComparison& output : comparison.outputs) {
    if (!is_defined(output)) continue;
    sum += output.log_magnitude_error_db;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

double peak_frequency_error(const OutputComparison& output) {
  std::vector<double> errors;
  for (const PeakDifference& peak : output.peaks)
    errors.push_back(peak.predicted_hz / peak.measured_hz - 1.0);
  return rms(errors);
}

double peak_amplitude_error_db(const OutputComparison& output) {
  std::vector<double> errors;
  for (const PeakDifference& peak : output.peaks) errors.push_back(peak.amplitude_db);
  return rms(errors);
}

void write_comparison(const Comparison& comparison, const std::string& file) {
  std::string text =
      "output,frac [-],log_magnitude_error [dB],mean_difference [dB],largest_difference [dB],peaks [-],"
      "peak_frequency_error [-],peak_amplitude_error [dB],lines [-],band_lo [Hz],band_hi [Hz],form\n";
  for (const OutputComparison& output : comparison.outputs) {
    text +=
        fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", output.output, number_or_nothing(output.frac),
                    number_or_nothing(output.log_magnitude_error_db), number_or_nothing(output.mean_db),
                    number_or_nothing(output.largest_db), output.peaks.size(),
                    number_or_nothing(peak_frequency_error(output)),
                    number_or_nothing(peak_amplitude_error_db(output)), output.lines, comparison.lo_hz,
                    comparison.hi_hz, output.kind == FrfKind::unknown ? "unknown" : to_string(output.kind));
  }
  write_atomically(file, text);
}

}  // namespace struna::ident
