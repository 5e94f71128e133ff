#include "ident/transfer_function.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <numbers>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

struct KindEntry {
  FrfKind kind;
  const char* word;
  const char* unit;
  Quantity output;
  Quantity input;
};

constexpr std::array kinds = {
    KindEntry{FrfKind::dynamic_stiffness, "dynamic-stiffness", "N/m", Quantity::force,
              Quantity::displacement},
    KindEntry{FrfKind::impedance, "impedance", "N s/m", Quantity::force, Quantity::velocity},
    KindEntry{FrfKind::apparent_mass, "apparent-mass", "kg", Quantity::force, Quantity::acceleration},
    KindEntry{FrfKind::receptance, "receptance", "m/N", Quantity::displacement, Quantity::force},
    KindEntry{FrfKind::mobility, "mobility", "m/s/N", Quantity::velocity, Quantity::force},
    KindEntry{FrfKind::accelerance, "accelerance", "m/s^2/N", Quantity::acceleration, Quantity::force},
};

const KindEntry* entry_of(FrfKind kind) {
  for (const KindEntry& entry : kinds)
    if (entry.kind == kind) return &entry;
  return nullptr;
}

bool force_over_motion(FrfKind kind) {
  return entry_of(kind)->output == Quantity::force;
}

/// The number of time derivatives of the motion quantity.
int derivatives(FrfKind kind) {
  const Quantity motion = force_over_motion(kind) ? entry_of(kind)->input : entry_of(kind)->output;
  return motion == Quantity::displacement ? 0 : motion == Quantity::velocity ? 1 : 2;
}

constexpr std::array estimators = {"h1", "h2", "hv", "amplitude-ratio"};

/// "N/m", or "m/s/(m)" for a pair that has no name.
std::string unit_of(Quantity output, Quantity input) {
  const FrfKind kind = kind_of(output, input);
  return kind == FrfKind::unknown ? fmt::format("{}/({})", si_unit(output), si_unit(input)) : unit_of(kind);
}

struct Densities {
  double input;
  double output;
  std::complex<double> cross;
};

std::complex<double> ratio(const Densities& s, Estimator estimator) {
  switch (estimator) {
    case Estimator::h1:
      return s.cross / s.input;
    case Estimator::h2:
      return s.output / std::conj(s.cross);
    case Estimator::hv:
      return std::polar(std::sqrt(s.output / s.input), std::arg(s.cross));
    case Estimator::amplitude_ratio:
      break;
  }
  return std::sqrt(s.output / s.input);
}

/// Standard deviation of the real and of the imaginary part; n - 1 because the scatter is taken about the
/// estimate itself.
double ratio_sigma(const Densities& s, double coherence, double averages, Estimator estimator) {
  const double noise = (1.0 - coherence) / (2.0 * (averages - 1.0));
  switch (estimator) {
    case Estimator::h1:
      return std::sqrt(noise * s.output / s.input);
    case Estimator::h2:
      return std::sqrt(noise * s.output / s.input) / coherence;
    case Estimator::hv:
      return std::sqrt(noise * s.output / (s.input * coherence));
    case Estimator::amplitude_ratio:
      break;
  }
  return std::sqrt((1.0 - coherence) / (2.0 * averages) * s.output / s.input);
}

/// Lines that say something about the function: not 0 Hz, whose value went with the mean, nor the Nyquist
/// line, which has no imaginary part, nor lines without any power to divide by: the lines between those of a
/// periodic input hold rounding only, 1e-30 of the largest one's power; 24 bits leave 1e-21.
std::vector<long> usable_lines(const Spectra& spectra, Estimator estimator) {
  const double nyquist = 0.5 / spectra.sample_interval;
  const double rounding = 1e-24 * spectra.input_auto.maxCoeff();
  std::vector<long> lines;
  for (long i = 1; i < spectra.frequency_hz.size(); ++i) {
    if (spectra.frequency_hz[i] > nyquist - 0.25 * spectra.resolution_hz ||
        !(spectra.input_auto[i] > rounding))
      continue;
    const bool divides_by_cross = estimator == Estimator::h2 || estimator == Estimator::hv;
    if (divides_by_cross && !(spectra.cross.row(i).cwiseAbs().minCoeff() > 0.0)) continue;
    lines.push_back(i);
  }
  return lines;
}

std::complex<double> integer_power(std::complex<double> base, int power) {
  std::complex<double> result = 1.0;
  for (int i = 0; i < std::abs(power); ++i) result *= base;
  return power < 0 ? 1.0 / result : result;
}

/// Inverts a drive-point function; first order in sigma.
void invert(TransferFunction::Output& output) {
  if (output.value.cwiseAbs().minCoeff() == 0.0)
    throw Error(fmt::format("convert: output '{}' is zero at a line and cannot be inverted", output.name));
  if (output.sigma.size() > 0) output.sigma = output.sigma.cwiseQuotient(output.value.cwiseAbs2());
  output.value = output.value.cwiseInverse();
}

FrfKind inverse_of(FrfKind kind) {
  const KindEntry* entry = entry_of(kind);
  return kind_of(entry->input, entry->output);
}

TransferFunction lines_from(const TransferFunction& tf, long first, long count) {
  TransferFunction part = tf;
  part.frequency_hz = tf.frequency_hz.segment(first, count);
  for (auto& output : part.outputs) {
    output.value = output.value.segment(first, count).eval();
    if (output.coherence.size() > 0) output.coherence = output.coherence.segment(first, count).eval();
    if (output.sigma.size() > 0) output.sigma = output.sigma.segment(first, count).eval();
  }
  return part;
}

}  // namespace

std::string unit_of(FrfKind kind) {
  if (kind == FrfKind::transmissibility) return "1";
  const KindEntry* entry = entry_of(kind);
  return entry ? entry->unit : "";
}

FrfKind kind_of_unit(const std::string& unit) {
  if (unit == "1") return FrfKind::transmissibility;
  for (const KindEntry& entry : kinds)
    if (unit == entry.unit) return entry.kind;
  return FrfKind::unknown;
}

std::string to_string(FrfKind kind) {
  if (kind == FrfKind::transmissibility) return "transmissibility";
  const KindEntry* entry = entry_of(kind);
  return entry ? entry->word : "unknown";
}

FrfKind frf_kind(const std::string& word) {
  std::string known;
  for (const KindEntry& entry : kinds) {
    if (word == entry.word) return entry.kind;
    known += (known.empty() ? "" : ", ") + std::string(entry.word);
  }
  throw Error("form must be " + known + ", got '" + word + "'");
}

FrfKind kind_of(Quantity output, Quantity input) {
  for (const KindEntry& entry : kinds)
    if (entry.output == output && entry.input == input) return entry.kind;
  return output == input && output != Quantity::unknown ? FrfKind::transmissibility : FrfKind::unknown;
}

Estimator estimator_kind(const std::string& word) {
  for (std::size_t i = 0; i < estimators.size(); ++i)
    if (word == estimators[i]) return static_cast<Estimator>(i);
  throw Error("estimator must be h1, h2, hv or amplitude-ratio, got '" + word + "'");
}

std::string to_string(Estimator estimator) {
  return estimators[static_cast<std::size_t>(estimator)];
}

TransferFunction::Output empty_output(const Channel& output, const Channel& input) {
  TransferFunction::Output empty;
  empty.name = output.name;
  empty.kind = kind_of(output.quantity, input.quantity);
  empty.unit = unit_of(output.quantity, input.quantity);
  return empty;
}

TransferFunction estimate_transfer_function(const Spectra& spectra, Estimator estimator) {
  const std::vector<long> lines = usable_lines(spectra, estimator);
  if (lines.empty()) throw Error("estimate_transfer_function: no line has any power");
  const bool averaged = spectra.effective_averages > 1.01;
  const long count = static_cast<long>(lines.size());
  TransferFunction tf;
  tf.exponential_decay = spectra.exponential_decay;
  tf.frequency_hz = spectra.frequency_hz(lines);
  for (long k = 0; k < spectra.cross.cols(); ++k) {
    const Channel& channel = spectra.outputs[static_cast<std::size_t>(k)];
    TransferFunction::Output output = empty_output(channel, spectra.input);
    output.value.resize(count);
    if (averaged) output.coherence.resize(count);
    if (averaged) output.sigma.resize(count);
    for (long i = 0; i < count; ++i) {
      const long line = lines[static_cast<std::size_t>(i)];
      const Densities s{spectra.input_auto[line], spectra.output_auto(line, k), spectra.cross(line, k)};
      output.value[i] = ratio(s, estimator);
      if (!averaged) continue;
      const double power = s.input * s.output;
      // Cauchy-Schwarz keeps it in [0, 1]; rounding may overstep by a few units in the last place.
      output.coherence[i] = power > 0.0 ? std::min(1.0, std::norm(s.cross) / power) : 0.0;
      output.sigma[i] = ratio_sigma(s, output.coherence[i], spectra.effective_averages, estimator);
    }
    tf.outputs.push_back(std::move(output));
  }
  return tf;
}

TransferFunction convert(const TransferFunction& tf, FrfKind kind) {
  if (!entry_of(kind)) throw Error("convert: the form '" + to_string(kind) + "' cannot be asked for");
  TransferFunction result = tf;
  bool has_zero_line = false;
  for (auto& output : result.outputs) {
    if (!entry_of(output.kind))
      throw Error(fmt::format(
          "convert: output '{}' [{}] is neither force over motion nor motion over force: it stays as "
          "measured",
          output.name, output.unit));
    if (force_over_motion(output.kind) != force_over_motion(kind)) {
      if (tf.outputs.size() != 1)
        throw Error(fmt::format(
            "convert: {} outputs cannot be inverted from {} to {}: only one drive-point function can",
            tf.outputs.size(), to_string(output.kind), to_string(kind)));
      invert(output);
      output.kind = inverse_of(output.kind);
    }
    // Motion over force gains a factor s per derivative, force over motion loses one. Under an exponential
    // window exp(-a t) the transform is that at s = a + i omega, so derivatives bring that factor.
    const int steps = derivatives(kind) - derivatives(output.kind);
    const int power = force_over_motion(kind) ? -steps : steps;
    has_zero_line = has_zero_line || power < 0;
    for (long i = 0; i < result.lines() && power != 0; ++i) {
      const std::complex<double> s(tf.exponential_decay, 2.0 * std::numbers::pi * tf.frequency_hz[i]);
      if (s == 0.0 && power < 0) continue;  // dropped below
      output.value[i] *= integer_power(s, power);
      if (output.sigma.size() > 0) output.sigma[i] *= std::pow(std::abs(s), power);
    }
    output.kind = kind;
    output.unit = unit_of(kind);
  }
  const bool drop =
      has_zero_line && tf.exponential_decay == 0.0 && tf.lines() > 0 && tf.frequency_hz[0] == 0.0;
  return drop ? lines_from(result, 1, result.lines() - 1) : result;
}

TransferFunction restrict_band(const TransferFunction& tf, double lo_hz, double hi_hz) {
  // A line written with rounded digits still belongs to a band that ends on it.
  const double slack = 1e-9 * std::abs(hi_hz);
  long first = 0;
  while (first < tf.lines() && tf.frequency_hz[first] < lo_hz - slack) ++first;
  long end = first;
  while (end < tf.lines() && tf.frequency_hz[end] <= hi_hz + slack) ++end;
  if (end == first)
    throw Error(tf.lines() == 0
                    ? std::string("restrict_band: the function has no lines")
                    : fmt::format("no line between {} and {} Hz: the lines reach from {:.6g} to {:.6g} Hz",
                                  lo_hz, hi_hz, tf.frequency_hz[0], tf.frequency_hz[tf.lines() - 1]));
  return lines_from(tf, first, end - first);
}

}  // namespace struna::ident
