#include "ident/spectra.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "ident/excitation.hpp"
#include "ident/fft.hpp"
#include "ident/hit.hpp"
#include "ident/repeat_spectra.hpp"

namespace struna::ident {
namespace {

constexpr long fewest_samples = 16;  // of a segment
constexpr double long_segment_hz = 0.1;
constexpr double most_samples = 1e12;  // beyond any record, within a long

/// Sums of products of segment spectra; column 0 of a segment is the input.
class Averager {
 public:
  Averager(long length, long channels)
      : fft_(length),
        auto_(Eigen::MatrixXd::Zero(length / 2 + 1, channels)),
        cross_(Eigen::MatrixXcd::Zero(length / 2 + 1, channels - 1)),
        square_(Eigen::VectorXd::Zero(length / 2 + 1)) {}

  void add(const Eigen::MatrixXd& segment, const Eigen::RowVectorXd& offset, const Eigen::VectorXd& taper) {
    for (long k = 0; k < segment.cols(); ++k) {
      fft_.input() = (segment.col(k).array() - offset[k]) * taper.array();
      const auto spectrum = fft_.transform();
      if (k > 0) {
        auto_.col(k) += spectrum.cwiseAbs2();
        cross_.col(k - 1) += input_.conjugate().cwiseProduct(spectrum);
        continue;
      }
      input_ = spectrum;
      power_ = spectrum.cwiseAbs2();
      auto_.col(0) += power_;
      square_ += power_.cwiseAbs2();
    }
    taper_power_ += taper.squaredNorm();
    ++segments_;
  }

  /// Whether the excitation passes over the lines one after the other.
  bool passes() const { return participation(auto_.col(0), square_, segments_) < passing_excitation; }

  long segments() const { return segments_; }

  /// One-sided densities: |X|^2 dt / sum w^2, doubled but for the lines that have no negative twin.
  void write_densities(double sample_interval, long length, Spectra& spectra) const {
    Eigen::VectorXd scale = Eigen::VectorXd::Constant(auto_.rows(), 2.0 * sample_interval / taper_power_);
    scale[0] *= 0.5;
    if (length % 2 == 0) scale[scale.size() - 1] *= 0.5;
    spectra.input_auto = scale.cwiseProduct(auto_.col(0));
    spectra.output_auto = scale.asDiagonal() * auto_.rightCols(cross_.cols());
    spectra.cross = scale.asDiagonal() * cross_;
  }

 private:
  Fft fft_;
  Eigen::VectorXcd input_;  ///< spectrum of the segment at hand
  Eigen::VectorXd power_;   ///< its |X|^2

  Eigen::MatrixXd auto_;
  Eigen::MatrixXcd cross_;
  Eigen::VectorXd square_;  ///< sum of |X|^4
  double taper_power_ = 0.0;
  long segments_ = 0;
};

struct Plan {
  Window window = Window::hann;
  bool whole = false;  ///< one segment per record
  long length = 0;     ///< of a segment
  long hop = 0;
  bool faded = false;  ///< whole records are sweeps, faded where they are cut off
};

void check(const WelchOptions& options) {
  const auto refuse = [](const std::string& what) { throw Error("welch_spectra: " + what); };
  if (!(options.resolution_hz >= 0.0) || !std::isfinite(options.resolution_hz))
    refuse(fmt::format("resolution must be positive, or 0 for automatic, got {}", options.resolution_hz));
  if (!(options.overlap >= 0.0 && options.overlap <= 0.9))
    refuse(fmt::format("overlap must be in [0, 0.9], got {}", options.overlap));
  if (!(options.exponential_end > 0.0 && options.exponential_end < 1.0))
    refuse(fmt::format("exponential_end must be in (0, 1), got {}", options.exponential_end));
  if (options.impact && options.window == Window::hann)
    refuse("a Hann window would suppress the hit of an impact test: use rectangular or exponential");
  if (!options.impact && options.window == Window::exponential)
    refuse(
        "an exponential window is for impact tests only: set impact (--impact), or use hann or rectangular");
}

Plan plan_whole(const std::vector<Repeat>& repeats, const WelchOptions& options) {
  Plan plan{options.window == Window::exponential ? Window::exponential : Window::rectangular, true, 0, 0};
  for (const Repeat& repeat : repeats) plan.length = std::max(plan.length, repeat.samples);
  if (options.impact && options.resolution_hz > 0.0)
    plan.length = std::lround(1.0 / (options.resolution_hz * repeats[0].sample_interval));
  return plan;
}

Plan plan_segments(const std::vector<Repeat>& repeats, const WelchOptions& options) {
  const double duration =
      options.resolution_hz > 0.0 ? 1.0 / options.resolution_hz : automatic_segment(repeats);
  Plan plan;
  plan.length = std::lround(std::min(duration / repeats[0].sample_interval, most_samples));
  if (options.resolution_hz == 0.0)  // rounding must not ask for a sample more than there is
    for (const Repeat& repeat : repeats) plan.length = std::min(plan.length, repeat.samples);
  if (options.window == Window::rectangular)
    plan.window = Window::rectangular;
  else
    plan.length = smooth_length(plan.length);
  plan.hop = std::max(1L, std::lround(static_cast<double>(plan.length) * (1.0 - options.overlap)));
  return plan;
}

[[noreturn]] void refuse_short(const Repeat& repeat, long samples, const Plan& plan) {
  const double resolution = 1.0 / (static_cast<double>(plan.length) * repeat.sample_interval);
  throw Error(
      repeat.name, 0,
      fmt::format(
          "{} samples are too few for a segment of {} ({:.4g} Hz): record for longer, or ask for a coarser "
          "resolution",
          samples, plan.length, resolution));
}

void check(const Plan& plan, const std::vector<Repeat>& repeats) {
  check_sampled_alike(repeats);
  for (const Repeat& repeat : repeats)
    if (!plan.whole && repeat.samples > 0 && plan.length > repeat.samples)
      refuse_short(repeat, repeat.samples, plan);
  if (plan.length < fewest_samples)
    throw Error(
        repeats[0].name, 0,
        fmt::format(
            "segments of {} samples are too short, at least {} are needed: record for longer, or ask for a "
            "finer resolution",
            plan.length, fewest_samples));
}

/// Streams a record through a buffer of one segment; returns the number of segments.
long add_segments(const Repeat& repeat, Rows& rows, const Plan& plan, const Eigen::VectorXd& taper,
                  long channels, Averager& averager) {
  Eigen::MatrixXd segment(plan.length, channels);
  Eigen::MatrixXd block;
  long filled = 0;
  long segments = 0;
  while (const long got = rows.read(block, std::min(4096L, plan.length - filled))) {
    segment.middleRows(filled, got) = block.topRows(got);
    filled += got;
    if (filled < plan.length) continue;
    averager.add(segment, segment.colwise().mean(), taper);
    ++segments;
    filled = plan.length - plan.hop;
    for (long k = 0; k < channels; ++k) {
      double* const column = segment.col(k).data();
      std::copy(column + plan.hop, column + plan.length, column);
    }
  }
  if (segments == 0) refuse_short(repeat, filled, plan);
  return segments;
}

/// Rms of the differences between neighbouring samples: how fast a signal moves, slow parts counting little.
double pace(const Eigen::VectorXd& samples, long from, long count) {
  return (samples.segment(from + 1, count - 1) - samples.segment(from, count - 1)).norm() /
         std::sqrt(static_cast<double>(count - 1));
}

/// Share of a sweep's record over which it is faded in or out where it is cut off in motion.
constexpr double fade = 0.01;

/// Whether the input comes in (seen from its first sample on) already moving and goes on doing so: a sweep
/// cut off. A hit or a burst begins from rest, or is over before long.
bool is_cut_off(const Eigen::VectorXd& input, long faded) {
  const long edge = std::max(faded / 10, 4L);
  const double within = pace(input, 0, faded);
  constexpr double moving = 0.1;
  return pace(input, 0, edge) > moving * within && pace(input, faded, faded) > moving * within;
}

/// Half a period of a cosine at each end at which the input is cut off in motion. What came before and what
/// comes after is missing in input and output alike, which no transfer function joins: a jump in the slope of
/// a displacement, whose spectrum falls like that of the sweep itself, spoils every line by the same share.
/// Faded over 1 % the lines of the first and the last hundredth of the sweep go, and the others become right.
Eigen::VectorXd sweep_taper(const Eigen::VectorXd& input, long length) {
  Eigen::VectorXd taper = Eigen::VectorXd::Ones(length);
  const long rows = input.size();
  const long faded = std::lround(fade * static_cast<double>(rows));
  if (faded < 8) return taper;
  const bool starts = is_cut_off(input, faded);
  const bool ends = is_cut_off(input.reverse(), faded);
  for (long i = 0; i < faded; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(faded);
    const double weight = 0.5 - 0.5 * std::cos(angle);
    if (starts) taper[i] = weight;
    if (ends) taper[rows - 1 - i] = weight;
  }
  return taper;
}

/// The whole record as one segment, at rest values taken out, followed by zeros up to the plan's length.
void add_whole(const Repeat& repeat, Rows& rows, const Plan& plan, const WelchOptions& options, long channels,
               Averager& averager, Spectra& spectra) {
  Eigen::MatrixXd samples = read_whole(repeat, rows, channels);
  Eigen::VectorXd taper = Eigen::VectorXd::Ones(plan.length);
  if (options.impact) {
    if (samples.rows() > plan.length) samples = samples.topRows(plan.length).eval();
    const Hit hit = find_hit(samples.col(0));
    samples.rowwise() -= rest_values(samples, hit);
    if (hit.second)
      spectra.warnings.push_back(repeat.name + ": a second hit follows the first one: leave this record out");
    if (plan.window == Window::exponential) {
      if (spectra.exponential_decay == 0.0)
        spectra.exponential_decay = -std::log(options.exponential_end) /
                                    (static_cast<double>(plan.length - hit.start) * repeat.sample_interval);
      taper = exponential_window(plan.length, hit.start, spectra.exponential_decay, repeat.sample_interval);
    }
    const Eigen::VectorXd tail =
        (samples.bottomRows(samples.rows() / 20).array().square().colwise().mean()).sqrt();
    const Eigen::VectorXd peak = samples.cwiseAbs().colwise().maxCoeff();
    for (long k = 1; k < channels && plan.window == Window::rectangular; ++k)
      if (tail[k] > 0.05 * peak[k])
        spectra.warnings.push_back(fmt::format(
            "{}: '{}' still moves when the record ends: a longer record or --window exponential is needed",
            repeat.name, spectra.outputs[static_cast<std::size_t>(k - 1)].name));
  } else {
    samples.rowwise() -= samples.colwise().mean().eval();
    if (plan.faded) taper = sweep_taper(samples.col(0), plan.length);
  }
  Eigen::MatrixXd segment = Eigen::MatrixXd::Zero(plan.length, channels);
  segment.topRows(samples.rows()) = samples;
  averager.add(segment, Eigen::RowVectorXd::Zero(channels), taper);
}

/// Whether the excitation passes over the lines one after the other; from segments of one record.
bool passes_over_lines(const Repeat& repeat, long channels, const WelchOptions& options) {
  const Plan plan = plan_segments({repeat}, options);
  if (plan.length < fewest_samples) return false;
  Averager averager(plan.length, channels);
  Rows rows = repeat.open();
  add_segments(repeat, rows, plan, hann_window(plan.length), channels, averager);
  return averager.passes();
}

/// A delay tau of a channel multiplied its spectrum by exp(-i omega tau).
void take_out_delays(Spectra& spectra) {
  for (long k = 0; k < spectra.cross.cols(); ++k) {
    const double delay = spectra.outputs[static_cast<std::size_t>(k)].delay - spectra.input.delay;
    if (std::abs(delay) * spectra.resolution_hz > 0.1)
      throw Error(fmt::format(
          "welch_spectra: the delay of {} s between input and output must be below a tenth of a segment "
          "({:.4g} s)",
          delay, 0.1 / spectra.resolution_hz));
    if (delay == 0.0) continue;
    const Eigen::ArrayXd angle = 2.0 * std::numbers::pi * delay * spectra.frequency_hz.array();
    for (long i = 0; i < angle.size(); ++i) spectra.cross(i, k) *= std::polar(1.0, angle[i]);
  }
}

Spectra estimate(const std::vector<Repeat>& repeats, const std::vector<Channel>& channels,
                 const WelchOptions& options, bool seen_passing = false) {
  const long count = static_cast<long>(channels.size());
  const bool undecided =
      options.window == Window::automatic && options.resolution_hz == 0.0 && !options.impact;
  const bool all_in_one =
      options.impact || (options.window == Window::rectangular && options.resolution_hz == 0.0);
  const bool passing =
      seen_passing || (undecided && repeats.size() > 2 && passes_over_lines(repeats[0], count, options));
  Plan plan = all_in_one || passing ? plan_whole(repeats, options) : plan_segments(repeats, options);
  plan.faded = passing;
  check(plan, repeats);

  Spectra spectra;
  spectra.input = channels[0];
  spectra.outputs.assign(channels.begin() + 1, channels.end());
  spectra.window = plan.window;
  const Eigen::VectorXd taper =
      plan.window == Window::hann ? hann_window(plan.length) : Eigen::VectorXd::Ones(plan.length);
  Averager averager(plan.length, count);
  double sample_interval = 0.0;
  for (const Repeat& repeat : repeats) {
    Rows rows = repeat.open();
    if (plan.whole) {
      add_whole(repeat, rows, plan, options, count, averager, spectra);
      spectra.effective_averages += 1.0;
    } else {
      const long segments = add_segments(repeat, rows, plan, taper, count, averager);
      spectra.effective_averages += effective_averages(taper, segments, plan.hop);
    }
    sample_interval += rows.sample_interval() / static_cast<double>(repeats.size());
  }
  // One or two records: their own segments tell whether they should have been taken whole.
  if (undecided && !passing && repeats.size() <= 2 && averager.passes()) {
    WelchOptions whole = options;
    whole.window = Window::rectangular;
    return estimate(repeats, channels, whole, true);
  }
  spectra.segments = static_cast<double>(averager.segments());
  spectra.sample_interval = sample_interval;
  spectra.resolution_hz = 1.0 / (static_cast<double>(plan.length) * sample_interval);
  averager.write_densities(sample_interval, plan.length, spectra);
  spectra.frequency_hz = Eigen::VectorXd::LinSpaced(spectra.input_auto.size(), 0.0,
                                                    static_cast<double>(spectra.input_auto.size() - 1)) *
                         spectra.resolution_hz;
  if (!(spectra.input_auto.maxCoeff() > 0.0))
    throw Error(
        fmt::format("welch_spectra: input '{}' is constant: there is no excitation", spectra.input.name));
  take_out_delays(spectra);
  return spectra;
}

}  // namespace

Spectra welch_spectra(const std::vector<std::string>& files, const std::string& input,
                      const std::vector<std::string>& outputs, const WelchOptions& options,
                      const std::map<std::string, ChannelCorrection>& corrections) {
  check(options);
  // Of long segments the length is checked before memory is taken for them.
  const bool by_length = options.impact || options.resolution_hz < long_segment_hz;
  const Repeats repeats = open_repeats(files, input, outputs, corrections, by_length);
  Spectra spectra = estimate(repeats.records, repeats.channels, options);
  for (auto& warning : record_warnings(repeats, options.impact))
    spectra.warnings.push_back(std::move(warning));
  return spectra;
}

Spectra welch_spectra(const Repeats& repeats, const WelchOptions& options) {
  check(options);
  return estimate(repeats.records, repeats.channels, options);
}

Spectra welch_spectra(const Record& record, const std::string& input, const std::vector<std::string>& outputs,
                      const WelchOptions& options) {
  return welch_spectra(open_repeats(record, input, outputs), options);
}

}  // namespace struna::ident
