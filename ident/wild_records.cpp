#include "ident/wild_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "ident/fft.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
constexpr long fewest_blocks = 5;
constexpr double nearest_pole = 0.25;  // of the weights: a denominator that small is a pole nearby

// Through three lines, barycentric: sum w_i H_i/(f - f_i) / sum w_i/(f - f_i), with the weights (orthogonal
// to 1 and to H) at which numerator and denominator are of degree one.
struct Moebius {
  std::array<double, 3> f;
  std::array<Complex, 3> h, w;
  Moebius(const Eigen::VectorXd& line_hz, const Eigen::VectorXcd& value, long first) {
    for (long i = 0; i < 3; ++i) {
      f[static_cast<std::size_t>(i)] = line_hz(first + i);
      h[static_cast<std::size_t>(i)] = value(first + i);
    }
    w = {h[2] - h[1], h[0] - h[2], h[1] - h[0]};
  }
  // false where the denominator nearly vanishes.
  bool at(double f_hz, Complex& result) const {
    Complex top = 0.0, bottom = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Complex part = w[i] / (f_hz - f[i]);
      top += part * h[i];
      bottom += part;
      size = std::max(size, std::abs(part));
    }
    if (!(std::abs(bottom) > nearest_pole * size)) return false;
    result = top / bottom;
    return true;
  }
};

long column_of(const Record& record, const std::string& name) {
  const auto found = std::find_if(record.channels.begin(), record.channels.end(),
                                  [&](const Channel& channel) { return channel.name == name; });
  if (found == record.channels.end())
    throw Error(fmt::format("WildRecords: the records have no channel '{}'", name));
  return found - record.channels.begin();
}

}  // namespace

Eigen::VectorXcd between_lines(const Eigen::VectorXd& line_hz, const Eigen::VectorXcd& value,
                               const Eigen::VectorXd& f_hz) {
  Eigen::VectorXcd result(f_hz.size());
  const long lines = line_hz.size();
  for (long k = 0; k < f_hz.size(); ++k) {
    const double f = f_hz(k);
    const long above =
        std::lower_bound(line_hz.data(), line_hz.data() + lines, f) - line_hz.data();  // first line >= f
    if (above == 0 || above == lines) {
      result(k) = value(above == 0 ? 0 : lines - 1);
      continue;
    }
    if (line_hz(above) == f) {
      result(k) = value(above);
      continue;
    }
    const double t = (f - line_hz(above - 1)) / (line_hz(above) - line_hz(above - 1));
    Complex sum = 0.0, one;
    double weight = 0.0;
    if (above >= 2 && Moebius(line_hz, value, above - 2).at(f, one)) {
      sum += (1.0 - t) * one;
      weight += 1.0 - t;
    }
    if (above + 1 < lines && Moebius(line_hz, value, above - 1).at(f, one)) {
      sum += t * one;
      weight += t;
    }
    result(k) = weight > 0.0 ? sum / weight : (1.0 - t) * value(above - 1) + t * value(above);
  }
  return result;
}

WildRecords::WildRecords(const std::vector<Record>& records, const std::string& input,
                         const std::vector<std::string>& outputs, const TransferEstimate& estimate,
                         bool impact, const WildOptions& options) {
  double samples = 0.0;
  for (const Record& record : records) samples += static_cast<double>(record.samples.rows());
  for (const Record& record : records) {
    const long in = column_of(record, input), length = record.samples.rows();
    Part part;
    part.made.start = record.start;
    part.made.sample_interval = record.sample_interval;
    part.made.samples.resize(length, 1 + static_cast<long>(outputs.size()));
    part.residual.resize(length, static_cast<long>(outputs.size()));
    part.made.channels.push_back(record.channels[static_cast<std::size_t>(in)]);
    const Eigen::VectorXd x = record.samples.col(in).array() - record.samples.col(in).mean();
    part.made.samples.col(0) = x;
    Fft fft(length);
    fft.input() = x;
    const Eigen::VectorXcd spectrum = fft.transform();
    const Eigen::VectorXd f =
        Eigen::VectorXd::LinSpaced(spectrum.size(), 0.0, static_cast<double>(spectrum.size() - 1)) /
        (static_cast<double>(length) * record.sample_interval);
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      const long out = column_of(record, outputs[k]), to = static_cast<long>(k);
      const Channel& channel = record.channels[static_cast<std::size_t>(out)];
      part.made.channels.push_back(channel);
      const double delay = channel.delay - part.made.channels[0].delay;
      Eigen::VectorXcd made =
          between_lines(estimate.function.frequency_hz, estimate.function.outputs[k].value, f)
              .cwiseProduct(spectrum);
      for (long i = 0; i < made.size(); ++i)
        made(i) *= std::polar(1.0, -2.0 * std::numbers::pi * f(i) * delay);
      made(0) = 0.0;
      if (length % 2 == 0) made(made.size() - 1) = made(made.size() - 1).real();
      part.made.samples.col(1 + to) = inverse_transform(made, length);
      part.residual.col(to) = record.samples.col(out).array() - record.samples.col(out).mean();
      part.residual.col(to) -= part.made.samples.col(1 + to);
    }
    if (impact || static_cast<long>(records.size()) >= fewest_blocks)
      part.block = length;
    else if (estimate.method == EstimateMethod::periodic)
      part.block = std::lround(1.0 / (estimate.resolution_hz * record.sample_interval));
    else
      part.block = std::max(1L, std::lround(samples / static_cast<double>(options.blocks)));
    blocks_ += (length + part.block - 1) / part.block;
    parts_.push_back(std::move(part));
  }
  if (blocks_ < fewest_blocks)
    throw Error(fmt::format("bootstrap: at least {} blocks ({}) are needed, got {}", fewest_blocks,
                            impact ? "hits" : "periods", blocks_));
}

std::vector<Record> WildRecords::draw(std::mt19937_64& random) const {
  // Fewer blocks than unknowns leave residuals smaller than the noise: (n/(n - 1)) of the variance for a
  // mean.
  const double few = std::sqrt(static_cast<double>(blocks_) / static_cast<double>(blocks_ - 1));
  std::vector<Record> records;
  for (const Part& part : parts_) {
    Record record = part.made;
    const long length = record.samples.rows();
    for (long first = 0; first < length; first += part.block) {
      const long count = std::min(part.block, length - first);
      const double sign = (random() & 1U) != 0U ? few : -few;
      record.samples.block(first, 1, count, part.residual.cols()) +=
          sign * part.residual.middleRows(first, count);
    }
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace struna::ident
