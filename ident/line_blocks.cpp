#include "ident/line_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace struna::ident {
namespace {

constexpr double block_share = 0.1;  // of the distance to the nearest pole
constexpr long least_blocks = 50;

// First line of each block, and the number of lines.
std::vector<long> block_starts(const TransferFunction& tf, const std::vector<Pole>& poles) {
  const long lines = tf.lines();
  const double spacing = (tf.frequency_hz(lines - 1) - tf.frequency_hz(0)) / static_cast<double>(lines - 1);
  std::vector<long> starts;
  for (long i = 0; i < lines;) {
    starts.push_back(i);
    double distance = tf.frequency_hz(lines - 1);
    for (const Pole& pole : poles)
      distance = std::min(
          distance, std::hypot(tf.frequency_hz(i) - pole.natural_frequency_hz, 0.5 * bandwidth_hz(pole)));
    i += std::clamp(static_cast<long>(block_share * distance / spacing), 1L,
                    std::max(1L, lines / least_blocks));
  }
  starts.push_back(lines);
  return starts;
}

}  // namespace

TransferFunction in_blocks(const TransferFunction& tf, const std::vector<long>& starts) {
  const auto blocks = static_cast<long>(starts.size()) - 1;
  TransferFunction result = tf;
  result.frequency_hz.resize(blocks);
  for (auto& output : result.outputs) {
    output.value.resize(blocks);
    output.sigma.resize(blocks);
    output.coherence.resize(0);
  }
  for (long b = 0; b < blocks; ++b) {
    const long first = starts[static_cast<std::size_t>(b)];
    const long count = starts[static_cast<std::size_t>(b) + 1] - first;
    result.frequency_hz(b) = tf.frequency_hz.segment(first, count).mean();
    for (std::size_t k = 0; k < tf.outputs.size(); ++k) {
      const auto& output = tf.outputs[k];
      const Eigen::ArrayXd weight = output.sigma.segment(first, count).array().square().inverse();
      const double sum = weight.sum();
      result.outputs[k].value(b) = (weight * output.value.segment(first, count).array()).sum() / sum;
      result.outputs[k].sigma(b) = 1.0 / std::sqrt(sum);
    }
  }
  return result;
}

TransferFunction in_blocks(const TransferFunction& tf, const std::vector<Pole>& poles) {
  return in_blocks(tf, block_starts(tf, poles));
}

}  // namespace struna::ident
