#include "ident/transfer_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "fem/error.hpp"
#include "ident/drive_signal.hpp"
#include "ident/excitation.hpp"
#include "ident/fft.hpp"
#include "ident/local_model.hpp"
#include "ident/periodic.hpp"
#include "ident/repeat_spectra.hpp"

namespace struna::ident {
namespace {

constexpr long reach = 2;  // of a local window: the least, so that neighbouring lines are nearly independent
constexpr long fine_reach = 3;  // at half the spacing
constexpr double window_spacings = 2 * reach + 1;
constexpr double own_lines = 12.0;       // of each record in a window, unless a resolution is asked for
constexpr double fewest_own = 8.0;       // the same, where one is; T takes three
constexpr double fewest_free = 10.0;     // lines of all records, less three for each T and three for N
constexpr double fewest_per_line = 7.0;  // lines of a record to a line, from which on half of it will do
constexpr double most_per_line = 16.0;   // lines of a record to a line asked for, in a local window

constexpr double reached_by_drive = 0.9;  // of the lines, from which on the others are not told

struct MethodEntry {
  const char* word;
  EstimateMethod method;
  Estimator ratio;
};
constexpr std::array methods = {
    MethodEntry{"auto", EstimateMethod::automatic, Estimator::h1},
    MethodEntry{"local", EstimateMethod::local_rational, Estimator::h1},
    MethodEntry{"local-polynomial", EstimateMethod::local_polynomial, Estimator::h1},
    MethodEntry{"periodic", EstimateMethod::periodic, Estimator::h1},
    MethodEntry{"welch", EstimateMethod::welch, Estimator::h1},
    MethodEntry{"h1", EstimateMethod::welch, Estimator::h1},
    MethodEntry{"h2", EstimateMethod::welch, Estimator::h2},
    MethodEntry{"hv", EstimateMethod::welch, Estimator::hv},
    MethodEntry{"amplitude-ratio", EstimateMethod::welch, Estimator::amplitude_ratio},
};

/// A record in memory and its spectrum.
struct Held {
  Eigen::MatrixXd samples;
  double sample_interval = 0.0;
  std::unique_ptr<Fft> fft;  ///< of the samples, the last ones left out where that makes the length smooth
  RecordSpectrum spectrum;
};

Held hold(const Repeat& record, const std::vector<Channel>& channels) {
  const long count = static_cast<long>(channels.size());
  Rows rows = record.open();
  Held held;
  held.samples = read_whole(record, rows, count);
  held.sample_interval = rows.sample_interval();
  held.samples.rowwise() -= held.samples.colwise().mean().eval();
  if (!(held.samples.col(0).squaredNorm() > 0.0))
    throw Error(record.name, 0,
                fmt::format("input '{}' is constant: there is no excitation", channels[0].name));
  return held;
}

void transform(Held& held) {
  held.fft = std::make_unique<Fft>(smooth_length(held.samples.rows()));
  Fft& fft = *held.fft;
  const double duration = static_cast<double>(fft.length()) * held.sample_interval;
  held.spectrum.line_spacing_hz = 1.0 / duration;
  held.spectrum.lines.resize(fft.length() / 2 + 1, held.samples.cols());
  const double scale = held.sample_interval / std::sqrt(duration);
  for (long c = 0; c < held.samples.cols(); ++c) {
    fft.input() = held.samples.col(c).head(fft.length());
    held.spectrum.lines.col(c) = scale * fft.transform();
  }
}

/// A delay tau of a channel multiplied its transform by exp(-i omega tau).
void take_out_delays(const std::vector<Channel>& channels, const Eigen::VectorXd& frequency_hz,
                     double line_spacing_hz, Eigen::Ref<Eigen::MatrixXcd> outputs) {
  for (long k = 0; k < outputs.cols(); ++k) {
    const double delay = channels[static_cast<std::size_t>(k + 1)].delay - channels[0].delay;
    if (delay == 0.0) continue;
    if (std::abs(delay) * line_spacing_hz > 0.1)
      throw Error(fmt::format(
          "estimate_transfer: the delay of {} s between input and output must be below a tenth of a record "
          "or period ({:.4g} s)",
          delay, 0.1 / line_spacing_hz));
    for (long i = 0; i < outputs.rows(); ++i)
      outputs(i, k) *= std::polar(1.0, 2.0 * std::numbers::pi * delay * frequency_hz[i]);
  }
}

/// Whether |H| of any output has a peak that falls to the height of a half-power band of six lines within two
/// lines on either side, and by five sigma.
bool has_narrow_peak(const LocalModel& model) {
  constexpr double height = 0.83, certain = 5.0;
  for (long k = 0; k < model.value.cols(); ++k) {
    const Eigen::VectorXd h = model.value.col(k).cwiseAbs();
    for (long i = 2; i + 2 < h.size(); ++i) {
      const double flank = std::max(h[i - 2], h[i + 2]);
      const bool peak = h[i] >= h[i - 1] && h[i] >= h[i + 1];
      if (peak && flank < height * h[i] &&
          h[i] - flank > certain * model.sigma.col(k).segment(i - 2, 5).maxCoeff())
        return true;
    }
  }
  return false;
}

class Estimation {
 public:
  Estimation(const Repeats& repeats, const EstimateOptions& options, std::function<Spectra()> welch)
      : repeats_(repeats), options_(options), welch_(std::move(welch)) {
    check();
  }

  TransferEstimate run() {
    const EstimateMethod asked = options_.method;
    if (asked == EstimateMethod::welch) return by_welch("asked for");
    if (asked == EstimateMethod::automatic) {
      if (const std::string reason = reason_for_segments(); !reason.empty()) return by_welch(reason);
      check_sampled_alike(repeats_.records);
      return automatic();
    }
    check_sampled_alike(repeats_.records);
    Held first = hold(repeats_.records[0], repeats_.channels);
    return asked == EstimateMethod::periodic ? periodic(first) : local(first, asked, "asked for");
  }

 private:
  long channels() const { return static_cast<long>(repeats_.channels.size()); }
  bool by_drive() const { return !options_.drive_signal.empty(); }
  long input() const { return by_drive() ? 1 : 0; }  ///< its channel
  bool speaks_of_segments() const {
    return options_.welch.impact || options_.welch.window != Window::automatic ||
           options_.welch.overlap != WelchOptions{}.overlap;
  }

  void check() const {
    const double resolution = options_.welch.resolution_hz;
    if (!(resolution >= 0.0) || !std::isfinite(resolution))
      throw Error(fmt::format("estimate_transfer: resolution must be positive, or 0 for automatic, got {}",
                              resolution));
    if (by_drive() &&
        (options_.method == EstimateMethod::welch || speaks_of_segments() || options_.ratio != Estimator::h1))
      refuse_segments_by_drive("Welch's averages, windows and hits do");
    const bool welch =
        options_.method == EstimateMethod::welch || options_.method == EstimateMethod::automatic;
    if (!welch && speaks_of_segments())
      throw Error(fmt::format(
          "estimate_transfer: a window, an overlap or an impact test goes with Welch's method, not with {}",
          to_string(options_.method)));
    if (options_.method == EstimateMethod::periodic && resolution > 0.0)
      throw Error(
          "estimate_transfer: the resolution of the periodic estimator is the excitation's: leave it out");
  }

  [[noreturn]] static void refuse_segments_by_drive(const std::string& why) {
    throw Error(
        fmt::format("estimate_transfer: a drive signal goes with the local estimators and the periodic one, "
                    "not with segments, but "
                    "{}: leave the drive signal out",
                    why));
  }

  std::string reason_for_segments() const {
    if (options_.welch.impact) return "each record is a hit";
    if (options_.welch.window != Window::automatic) return "a window is asked for";
    if (speaks_of_segments()) return "an overlap is asked for";
    if (options_.ratio != Estimator::h1) return to_string(options_.ratio) + " is asked for";
    for (const Repeat& record : repeats_.records)
      if (record.samples * channels() > most_values)
        return fmt::format("{} samples of {} channels are streamed rather than held in memory",
                           record.samples, channels());
    return "";
  }

  TransferEstimate automatic() {
    Held first = hold(repeats_.records[0], repeats_.channels);
    transform(first);
    if (const long period = period_of(first); period > 0) {
      if (options_.welch.resolution_hz == 0.0) {
        if (auto all = all_periodic(first, period); !all.empty())
          return periodic(all, period, "the excitation repeats itself");
      }
    }
    if (passes_over_lines(first.samples.col(0)))
      return by_welch("the excitation passes over the lines one after the other");
    if (!window_is_filled())
      return by_welch(fmt::format("a local model would have {:.0f} lines of a record in its window, too few",
                                  lines_in_window(shortest())));
    return local(first, EstimateMethod::local_rational, "steady excitation that does not repeat itself");
  }

  double shortest() const {
    double shortest = repeats_.records[0].duration();
    for (const Repeat& record : repeats_.records) shortest = std::min(shortest, record.duration());
    return shortest;
  }
  /// Of a local model; many short records need a wider window than Welch's lines would give.
  double line_spacing() const {
    if (options_.welch.resolution_hz > 0.0) return options_.welch.resolution_hz;
    return std::max(1.0 / automatic_segment(repeats_.records), own_lines / (window_spacings * shortest()));
  }
  double lines_in_window(double duration) const { return window_spacings * line_spacing() * duration; }
  /// Whether a local model's window has enough lines: of each record for its own unknowns, and of all
  /// together.
  bool window_is_filled() const {
    double free = -3.0;
    for (const Repeat& record : repeats_.records) free += lines_in_window(record.duration()) - 3.0;
    return free >= fewest_free && lines_in_window(shortest()) >= fewest_own;
  }

  static long period_of(const Held& held) {
    return find_period(held.samples.col(0), held.spectrum.lines.col(0), *held.fft);
  }
  /// Every record's samples, or none where one does not have the period.
  std::vector<Eigen::MatrixXd> all_periodic(const Held& first, long period) const {
    std::vector<Eigen::MatrixXd> all{first.samples};
    for (std::size_t k = 1; k < repeats_.records.size(); ++k) {
      Held next = hold(repeats_.records[k], repeats_.channels);
      transform(next);
      if (period_of(next) != period) return {};
      all.push_back(std::move(next.samples));
    }
    return all;
  }

  TransferEstimate periodic(Held& first) const {
    transform(first);
    const long period = period_of(first);
    const auto all = period > 0 ? all_periodic(first, period) : std::vector<Eigen::MatrixXd>{};
    if (all.empty())
      throw Error(repeats_.records[0].name, 0,
                  "the input does not repeat itself with a period of whole samples, the same in all records: "
                  "use another estimator");
    return periodic(all, period, "asked for");
  }

  TransferEstimate periodic(const std::vector<Eigen::MatrixXd>& records, long period,
                            const std::string& reason) const {
    const double interval = repeats_.records[0].sample_interval;
    std::vector<Eigen::MatrixXd> measured;  // means over periods have no noise for a drive signal to take out
    for (const Eigen::MatrixXd& record : records) measured.push_back(record.rightCols(channels() - input()));
    PeriodicEstimate found = periodic_estimate(measured, period, interval);
    if (found.frequency_hz.size() == 0)
      throw Error("estimate_transfer: no line of the periodic input stands out of its noise");
    TransferEstimate estimate = described(EstimateMethod::periodic, reason);
    estimate.segments = estimate.effective_averages = static_cast<double>(found.periods);
    estimate.resolution_hz = estimate.independent_line_hz = 1.0 / (static_cast<double>(period) * interval);
    estimate.sample_interval = interval;
    if (found.settling > 0)
      estimate.warnings.push_back(
          fmt::format("{} period(s) of {:.4g} s are left out: the response was still settling",
                      found.settling, static_cast<double>(period) * interval));
    take_out_delays({repeats_.channels.begin() + input(), repeats_.channels.end()}, found.frequency_hz,
                    estimate.resolution_hz, found.value);
    fill(found.frequency_hz, found.value, found.sigma, found.coherence, estimate.function);
    estimate.function.leakage_hz = 0.0;
    return estimate;
  }

  TransferEstimate local(Held& first, EstimateMethod method, const std::string& reason) const {
    TransferEstimate estimate = described(method, reason);
    const double nyquist = 0.5 / first.sample_interval;
    std::vector<RecordSpectrum> spectra;
    for (std::size_t k = 0; k < repeats_.records.size(); ++k) {
      Held held = k == 0 ? std::move(first) : hold(repeats_.records[k], repeats_.channels);
      if (!held.fft) transform(held);
      const double line_hz = held.spectrum.line_spacing_hz;
      const long lines = held.spectrum.lines.rows();
      take_out_delays(repeats_.channels,
                      Eigen::VectorXd::LinSpaced(lines, 0.0, line_hz * static_cast<double>(lines - 1)),
                      line_hz, held.spectrum.lines.rightCols(channels() - 1));
      estimate.independent_line_hz = std::max(estimate.independent_line_hz, line_hz);
      estimate.sample_interval += held.sample_interval / static_cast<double>(repeats_.records.size());
      spectra.push_back(std::move(held.spectrum));
    }
    estimate.segments = static_cast<double>(repeats_.records.size());
    const LocalModel model = finest_needed(spectra, nyquist, method, estimate.resolution_hz);
    if (model.frequency_hz.size() == 0)
      throw Error(
          by_drive()
              ? "estimate_transfer: the drive signal moves the input at no line: is it the right channel?"
              : "estimate_transfer: no line has any power");
    const long all = std::lround(nyquist / estimate.resolution_hz), left = model.frequency_hz.size();
    if (by_drive() && static_cast<double>(left) < reached_by_drive * static_cast<double>(all))
      estimate.warnings.push_back(fmt::format(
          "{} of {} lines are left out: there the drive signal moves '{}' too little against its noise",
          all - left, all, estimate.input.name));
    fill(model.frequency_hz, model.value, model.sigma, model.coherence, estimate.function);
    const bool leaks = method == EstimateMethod::local_polynomial;
    estimate.function.leakage_hz = leaks ? local_polynomial_leakage * estimate.resolution_hz : 0.0;
    return estimate;
  }

  /// The model at the spacing asked for, or at half the usual one where a resonance wants it.
  LocalModel finest_needed(const std::vector<RecordSpectrum>& spectra, double nyquist, EstimateMethod method,
                           double& spacing) const {
    spacing = line_spacing();
    LocalModelOptions model_options;
    model_options.form =
        method == EstimateMethod::local_rational ? LocalForm::rational : LocalForm::polynomial;
    model_options.reach = reach;
    const double lines = spacing * repeats_.records[0].duration();
    // Lines farther apart than a window is wide: those between are left out.
    if (options_.welch.resolution_hz > 0.0)
      model_options.stride = std::max(1L, std::lround(std::ceil(lines / most_per_line)));
    model_options.line_spacing_hz = spacing / static_cast<double>(model_options.stride);
    const auto estimated = [&] {
      return by_drive() ? local_model_by_drive(spectra, nyquist, model_options)
                        : local_model(spectra, nyquist, model_options);
    };
    LocalModel model = estimated();
    const bool fixed = options_.welch.resolution_hz > 0.0 || lines < fewest_per_line;
    if (fixed || method != EstimateMethod::local_rational || !has_narrow_peak(model)) return model;
    spacing *= 0.5;
    model_options.line_spacing_hz = spacing;
    model_options.reach = fine_reach;
    return estimated();
  }

  TransferEstimate by_welch(const std::string& reason) const {
    if (by_drive()) refuse_segments_by_drive(reason);
    Spectra spectra = welch_();
    TransferEstimate estimate = described(EstimateMethod::welch, reason);
    estimate.function = estimate_transfer_function(spectra, options_.ratio);
    estimate.sample_interval = spectra.sample_interval;
    estimate.resolution_hz = estimate.independent_line_hz = spectra.resolution_hz;
    estimate.segments = spectra.segments;
    estimate.effective_averages = spectra.effective_averages;
    estimate.window = spectra.window;
    estimate.warnings = std::move(spectra.warnings);
    // Hits, and sweeps for which the program takes one segment, decay within it. By how much other windows,
    // H2 and its kin leak is not told.
    const bool decays = options_.welch.impact ||
                        (options_.welch.window == Window::automatic && spectra.window != Window::hann);
    if (decays)
      estimate.function.leakage_hz = 0.0;
    else if (spectra.window == Window::hann && options_.ratio == Estimator::h1)
      estimate.function.leakage_hz = spectra.resolution_hz;
    return estimate;
  }

  TransferEstimate described(EstimateMethod method, const std::string& reason) const {
    TransferEstimate estimate;
    estimate.method = method;
    estimate.ratio = options_.ratio;
    estimate.reason = reason;
    estimate.drive_signal = options_.drive_signal;
    estimate.input = repeats_.channels[static_cast<std::size_t>(input())];
    return estimate;
  }
  void fill(const Eigen::VectorXd& frequency_hz, const Eigen::MatrixXcd& value, const Eigen::MatrixXd& sigma,
            const Eigen::MatrixXd& coherence, TransferFunction& tf) const {
    tf.frequency_hz = frequency_hz;
    for (long k = 0; k < value.cols(); ++k) {
      auto output = empty_output(repeats_.channels[static_cast<std::size_t>(input() + k + 1)],
                                 repeats_.channels[static_cast<std::size_t>(input())]);
      output.value = value.col(k);
      output.sigma = sigma.col(k);
      output.coherence = coherence.col(k);
      tf.outputs.push_back(std::move(output));
    }
  }

  const Repeats& repeats_;
  EstimateOptions options_;
  std::function<Spectra()> welch_;
};

/// The drive signal, where there is one, takes the input's place, and the input comes before the outputs.
std::pair<std::string, std::vector<std::string>> channels_by_drive(const EstimateOptions& options,
                                                                   const std::string& input,
                                                                   std::vector<std::string> outputs) {
  if (options.drive_signal.empty()) return {input, std::move(outputs)};
  outputs.insert(outputs.begin(), input);
  return {options.drive_signal, std::move(outputs)};
}

}  // namespace

std::string to_string(EstimateMethod method) {
  switch (method) {
    case EstimateMethod::automatic:
      return "automatic";
    case EstimateMethod::welch:
      return "Welch";
    case EstimateMethod::local_rational:
      return "local rational model";
    case EstimateMethod::local_polynomial:
      return "local polynomial model";
    case EstimateMethod::periodic:
      break;
  }
  return "mean over periods";
}

EstimatorWord estimator_word(const std::string& word) {
  std::string known;
  for (const MethodEntry& entry : methods) {
    if (word == entry.word) return {entry.method, entry.ratio};
    known += (known.empty() ? "" : ", ") + std::string(entry.word);
  }
  throw Error("estimator must be one of " + known + ", got '" + word + "'");
}

TransferEstimate estimate_transfer(const std::vector<std::string>& files, const std::string& input,
                                   const std::vector<std::string>& outputs, const EstimateOptions& options,
                                   const std::map<std::string, ChannelCorrection>& corrections) {
  const bool welch = options.method == EstimateMethod::welch;
  const auto [first, others] = channels_by_drive(options, input, outputs);
  auto corrected = corrections;
  if (first != input) corrected[first].unit = "N";  // not what it is written in: its scale drops out
  const Repeats repeats = open_repeats(files, first, others, corrected, !welch);
  TransferEstimate estimate = Estimation(repeats, options, [&] {
                                return welch_spectra(files, input, outputs, options.welch, corrections);
                              }).run();
  if (estimate.method == EstimateMethod::welch) return estimate;  // it has told of the records
  for (auto& warning : record_warnings(repeats, options.welch.impact))
    estimate.warnings.push_back(std::move(warning));
  return estimate;
}

TransferEstimate estimate_transfer(const Record& record, const std::string& input,
                                   const std::vector<std::string>& outputs, const EstimateOptions& options) {
  const auto [first, others] = channels_by_drive(options, input, outputs);
  const Repeats repeats = open_repeats(record, first, others);
  return Estimation(repeats, options, [&] { return welch_spectra(record, input, outputs, options.welch); })
      .run();
}

TransferEstimate estimate_transfer(const std::vector<Record>& records, const std::string& input,
                                   const std::vector<std::string>& outputs, const EstimateOptions& options) {
  const auto [first, others] = channels_by_drive(options, input, outputs);
  const Repeats repeats = open_repeats(records, first, others);
  return Estimation(repeats, options, [&] { return welch_spectra(repeats, options.welch); }).run();
}

}  // namespace struna::ident
