#include "ident/local_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/error.hpp"
#include "ident/local_window.hpp"

namespace struna::ident {
namespace {

using namespace local;
constexpr long tile = 64;  // windows whose sums are made together: they stay in the processor's cache
constexpr long fewest_lines = 2 * terms + 2;  // of a record in a window

/// Sums of products in powers of r: `parts` of `rows` powers by `channels` each.
struct Part {
  long first;
  long rows;
  long channels;
};

/// Line sums of consecutive blocks of one line spacing. A row is one power of one product over the blocks, so
/// that shifts are long vector operations.
class BlockSums {
 public:
  BlockSums(const RecordSpectrum& record, double spacing_hz, double half_width_hz, long outputs)
      : record_(record),
        spacing_hz_(spacing_hz),
        half_width_hz_(half_width_hz),
        channels_(line_channels(outputs)),
        parts_{Part{0, orders, channels_}, Part{orders * channels_, count_orders, 1}} {}

  long size() const { return orders * channels_ + count_orders; }
  const std::array<Part, 2>& parts() const { return parts_; }

  /// Blocks first .. first + count - 1, about the middle of each.
  Eigen::MatrixXd of(long first, long count) const {
    Eigen::MatrixXd sums(count, size());
    Eigen::VectorXd block(size());
    std::vector<double> line(static_cast<std::size_t>(channels_));
    for (long b = 0; b < count; ++b) {
      block.setZero();
      const double middle = static_cast<double>(first + b) * spacing_hz_;
      const long end = std::min(first_line(first + b + 1), static_cast<long>(record_.lines.rows()));
      for (long k = std::max(1L, first_line(first + b)); k < end; ++k) {  // 0 Hz went with the mean
        products(k, line.data());
        add((static_cast<double>(k) * record_.line_spacing_hz - middle) / half_width_hz_, line, block);
      }
      sums.row(b) = block;
    }
    return sums;
  }

 private:
  long first_line(long block) const {
    const double edge = (static_cast<double>(block) - 0.5) * spacing_hz_ / record_.line_spacing_hz;
    return static_cast<long>(std::ceil(edge - 1e-6));  // a line on an edge belongs to the block above
  }
  void products(long k, double* line) const {
    const std::complex<double> x = record_.lines(k, 0);
    line[0] = 1.0;
    line[1] = x.real() * x.real() + x.imag() * x.imag();
    line[2] = x.real();
    line[3] = x.imag();
    for (long o = 1; o < record_.lines.cols(); ++o) {
      const std::complex<double> y = record_.lines(k, o);
      double* const at = line + input_channels + output_channels * (o - 1);
      at[0] = y.real() * y.real() + y.imag() * y.imag();
      at[1] = y.real();
      at[2] = y.imag();
      at[3] = x.real() * y.real() + x.imag() * y.imag();
      at[4] = x.real() * y.imag() - x.imag() * y.real();
    }
  }
  void add(double r, const std::vector<double>& line, Eigen::VectorXd& block) const {
    double power = 1.0;
    double* to = block.data();
    double* const counts = to + orders * channels_;
    for (long p = 0; p < count_orders; ++p, power *= r) {
      counts[p] += power;
      if (p >= orders) continue;
      for (long c = 0; c < channels_; ++c) to[c] += power * line[static_cast<std::size_t>(c)];
      to += channels_;
    }
  }

  const RecordSpectrum& record_;
  double spacing_hz_, half_width_hz_;
  long channels_;
  std::array<Part, 2> parts_;
};

/// Adds sums about one point to sums about a point `shift` half widths below it:
/// sum (r + shift)^p = sum_q C(p, q) shift^(p - q) sum r^q.
template <class From, class To>
void add_shifted(const std::array<Part, 2>& parts, const From& from, double shift, To&& to) {
  for (const Part& part : parts)
    for (long p = 0; p < part.rows; ++p) {
      double factor = 1.0;
      for (long q = p; q >= 0; --q) {
        to.middleCols(part.first + p * part.channels, part.channels) +=
            factor * from.middleCols(part.first + q * part.channels, part.channels);
        factor *= shift * static_cast<double>(q) / static_cast<double>(p - q + 1);
        if (factor == 0.0) break;
      }
    }
}

/// Sums over `width` consecutive blocks about their middle, from blocks doubled again and again.
Eigen::MatrixXd sum_windows(const std::array<Part, 2>& parts, Eigen::MatrixXd blocks, long width,
                            double block_width) {
  const long windows = blocks.rows() - width + 1;
  const double middle = 0.5 * static_cast<double>(width - 1);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(windows, blocks.cols());
  long done = 0;
  for (long length = 1; length <= width; length *= 2) {
    if (width & length) {
      const double shift = (static_cast<double>(done) - middle) * block_width;
      add_shifted(parts, blocks.middleRows(done, windows), shift, sums);
      done += length;
    }
    if (2 * length > width) break;
    const long rows = blocks.rows() - length;
    Eigen::MatrixXd doubled = blocks.topRows(rows);
    add_shifted(parts, blocks.bottomRows(rows), static_cast<double>(length) * block_width, doubled);
    blocks = std::move(doubled);
  }
  return sums;
}

void check(const std::vector<RecordSpectrum>& records, const LocalModelOptions& options) {
  const auto refuse = [](const std::string& what) { throw Error("local_model: " + what); };
  if (!(options.line_spacing_hz > 0.0) || !std::isfinite(options.line_spacing_hz))
    refuse(fmt::format("line spacing must be positive, got {}", options.line_spacing_hz));
  if (options.reach < 1) refuse(fmt::format("reach must be at least 1, got {}", options.reach));
  if (options.stride < 1) refuse(fmt::format("stride must be at least 1, got {}", options.stride));
  if (records.empty()) refuse("at least one record is needed");
  const long channels = records.front().lines.cols();
  if (channels < 2)
    refuse(fmt::format("an input and at least one output are needed, got {} channels", channels));
  for (const RecordSpectrum& record : records) {
    if (record.lines.cols() != channels)
      refuse(fmt::format("a record of {} channels among others of {}", record.lines.cols(), channels));
    const double lines =
        static_cast<double>(2 * options.reach + 1) * options.line_spacing_hz / record.line_spacing_hz;
    if (!(lines >= static_cast<double>(fewest_lines)))
      refuse(fmt::format(
          "{:.1f} lines of a record in a window, at least {} are needed: record for longer, or ask "
          "for a coarser resolution",
          lines, fewest_lines));
  }
}

/// Sums of the windows of lines begin .. end - 1 over all records, T eliminated, `lanes` windows in a column.
class TileSums {
 public:
  TileSums(const std::vector<RecordSpectrum>& records, long windows, const LocalModelOptions& options)
      : reach_(options.reach),
        windows_(windows),
        outputs_(records.front().lines.cols() - 1),
        step_(1.0 / (static_cast<double>(options.reach) + 0.5)) {
    const double half_width = options.line_spacing_hz / step_;
    for (const RecordSpectrum& record : records)
      blocks_.emplace_back(record, options.line_spacing_hz, half_width, outputs_);
    lane_sums_.resize(lanes, blocks_.front().size());
  }

  const Eigen::MatrixXd& of(long begin, long end) {
    sums_.setZero(lanes * Layout::size(outputs_), (end - begin + lanes - 1) / lanes);
    const long first = middle_of(begin), last = middle_of(end - 1), width = 2 * reach_ + 1;
    for (const BlockSums& blocks : blocks_) {
      const Eigen::MatrixXd windows =
          sum_windows(blocks.parts(), blocks.of(first - reach_, last - first + width), width, step_);
      for (long j = begin; j < end; j += lanes) {
        for (long lane = 0; lane < lanes; ++lane)
          take(blocks, windows, std::min(j + lane, end - 1), first, lane);
        eliminate_transient(lane_sums_.data(), outputs_, sums_.col((j - begin) / lanes).data());
      }
    }
    return sums_;
  }

 private:
  /// At the ends of the spectrum windows stay where they are while the line moves out of their middle.
  long middle_of(long line) const { return std::clamp(line, reach_, windows_ - 1 - reach_); }
  void take(const BlockSums& blocks, const Eigen::MatrixXd& windows, long line, long first, long lane) {
    const auto window = windows.row(middle_of(line) - first);
    if (middle_of(line) == line) {
      lane_sums_.row(lane) = window;
      return;
    }
    lane_sums_.row(lane).setZero();
    const double shift = static_cast<double>(middle_of(line) - line) * step_;
    add_shifted(blocks.parts(), window, shift, lane_sums_.row(lane));
  }

  long reach_, windows_, outputs_;
  double step_;  ///< line spacing over half width
  std::vector<BlockSums> blocks_;
  Eigen::MatrixXd lane_sums_, sums_;
};

/// Lines written one by one into arrays that have room for all.
class ModelWriter {
 public:
  ModelWriter(long lines, long outputs) {
    model_.frequency_hz.resize(lines);
    model_.input_power.resize(lines);
    model_.value.resize(lines, outputs);
    for (Eigen::MatrixXd* m : {&model_.sigma, &model_.coherence, &model_.noise_power})
      m->resize(lines, outputs);
  }
  void write(const WindowFit& fit, long lane, double frequency_hz) {
    model_.frequency_hz[line_] = frequency_hz;
    model_.input_power[line_] = fit.input_power()[lane];
    for (long o = 0; o < model_.value.cols(); ++o) {
      const WindowFit::Estimate& e = fit.estimate(o);
      const double signal = e.value.norm()[lane] * fit.input_power()[lane];
      model_.value(line_, o) = {e.value.re[lane], e.value.im[lane]};
      model_.sigma(line_, o) = std::sqrt(0.5 * e.variance[lane]);
      model_.noise_power(line_, o) = e.noise_power[lane];
      model_.coherence(line_, o) = signal / (signal + e.noise_power[lane]);
    }
    ++line_;
  }
  LocalModel finish() {
    const long outputs = model_.value.cols();
    model_.frequency_hz.conservativeResize(line_);
    model_.input_power.conservativeResize(line_);
    model_.value.conservativeResize(line_, outputs);
    for (Eigen::MatrixXd* m : {&model_.sigma, &model_.coherence, &model_.noise_power})
      m->conservativeResize(line_, outputs);
    return std::move(model_);
  }

 private:
  LocalModel model_;
  long line_ = 0;
};

}  // namespace

LocalModel local_model(const std::vector<RecordSpectrum>& records, double highest_hz,
                       const LocalModelOptions& options) {
  check(records, options);
  const double spacing = options.line_spacing_hz;
  const long windows = static_cast<long>(std::floor(highest_hz / spacing - 0.5)) + 1;
  if (windows < 2 * options.reach + 1)
    throw Error(fmt::format(
        "local_model: {} lines up to {:.6g} Hz are fewer than a window's {}: ask for a finer resolution",
        windows, highest_hz, 2 * options.reach + 1));
  const long outputs = records.front().lines.cols() - 1;
  TileSums sums(records, windows, options);
  ModelWriter writer(windows / options.stride + 1, outputs);
  for (long begin = 0; begin < windows; begin += tile) {
    const long end = std::min(begin + tile, windows);
    const Eigen::MatrixXd& tile_sums = sums.of(begin, end);
    for (long j = begin; j < end; j += lanes) {
      const auto wanted = [&](long lane) {
        return j + lane > 0 && j + lane < end && (j + lane) % options.stride == 0;
      };
      if (!(wanted(0) || wanted(1) || wanted(2) || wanted(3))) continue;
      const WindowFit fit(tile_sums.col((j - begin) / lanes).data(), outputs, options.form);
      for (long lane = 0; lane < lanes; ++lane)
        if (wanted(lane) && fit.usable(lane))
          writer.write(fit, lane, static_cast<double>(j + lane) * spacing);
    }
  }
  return writer.finish();
}

}  // namespace struna::ident
