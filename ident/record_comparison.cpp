#include "ident/record_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/error.hpp"
#include "ident/spectra.hpp"

namespace struna::ident {
namespace {

/// Pearson's correlation; NaN where either signal does not move.
double correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd x = a.array() - a.mean();
  const Eigen::VectorXd y = b.array() - b.mean();
  const double norms = x.norm() * y.norm();
  return norms > 0.0 ? x.dot(y) / norms : std::numeric_limits<double>::quiet_NaN();
}

/// A channel moves when it leaves its first value.
bool moves(const Eigen::VectorXd& signal) {
  return (signal.array() != signal[0]).any();
}

long column_of(const Record& record, const std::string& name) {
  for (std::size_t k = 0; k < record.channels.size(); ++k) {
    if (record.channels[k].name == name) return static_cast<long>(k);
  }
  return -1;
}

HalfOctaveLevels levels_of(const Record& record, long column, long first, long count,
                           const Eigen::VectorXd& edge_hz) {
  // Welch's spectra want an input and an output: the signal is both.
  Record signal;
  signal.sample_interval = record.sample_interval;
  signal.channels = {{"signal", Quantity::unknown, 0.0}, {"same", Quantity::unknown, 0.0}};
  signal.samples = record.samples.col(column).segment(first, count).replicate(1, 2);
  WelchOptions options;
  options.window = Window::hann;
  const Spectra spectra = welch_spectra(signal, "signal", {"same"}, options);
  return half_octave_levels(spectra.frequency_hz, spectra.input_auto, edge_hz);
}

}  // namespace

Eigen::VectorXd half_octave_edges(double lo_hz, double hi_hz) {
  const double bands = lo_hz > 0.0 && hi_hz > lo_hz ? std::floor(2.0 * std::log2(1.01 * hi_hz / lo_hz)) : 0.0;
  if (bands < 1.0) {
    throw Error(fmt::format("half_octave_edges: no half octave fits into {:g} to {:g} Hz", lo_hz, hi_hz));
  }
  Eigen::VectorXd edge(static_cast<long>(bands) + 1);
  for (long k = 0; k < edge.size(); ++k) edge[k] = lo_hz * std::exp2(0.5 * static_cast<double>(k));
  return edge;
}

HalfOctaveLevels half_octave_levels(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& density,
                                    const Eigen::VectorXd& edge_hz) {
  if (frequency_hz.size() < 2 || density.size() != frequency_hz.size()) {
    throw Error(fmt::format("half_octave_levels: needs two lines or more, each with a density, got {} and {}",
                            frequency_hz.size(), density.size()));
  }
  const double spacing = frequency_hz[1] - frequency_hz[0];
  HalfOctaveLevels levels{edge_hz, Eigen::VectorXd::Zero(edge_hz.size() - 1)};
  for (long band = 0; band < levels.bands(); ++band) {
    double power = 0.0;
    for (long i = 0; i < frequency_hz.size(); ++i) {
      const double lo = std::max(frequency_hz[i] - 0.5 * spacing, edge_hz[band]);
      const double hi = std::min(frequency_hz[i] + 0.5 * spacing, edge_hz[band + 1]);
      if (hi > lo) power += density[i] * (hi - lo);
    }
    levels.rms[band] = std::sqrt(power);
  }
  return levels;
}

void require_comparable(const Record& measured, double sample_interval, long samples,
                        const RecordComparisonOptions& options) {
  const double ratio = measured.sample_interval / sample_interval;
  if (!(std::abs(ratio - 1.0) <= 1e-6)) {
    throw Error(fmt::format(
        "compare_records: both records need the same sampling interval, got {:g} s measured and {:g} s "
        "simulated; set sample_rate = {:g} in the scene",
        measured.sample_interval, sample_interval, 1.0 / measured.sample_interval));
  }
  if (!(options.interval > 0.0) || !(options.skip >= 0.0)) {
    throw Error(fmt::format("compare_records: needs interval > 0 and skip >= 0, got {:g} and {:g}",
                            options.interval, options.skip));
  }
  const double common = static_cast<double>(std::min(measured.samples.rows(), samples)) * sample_interval;
  if (common - options.skip < options.interval * (1.0 - 1e-9) || options.interval < 2.0 * sample_interval) {
    throw Error(fmt::format(
        "compare_records: the common {:g} s are too short for intervals of {:g} s after {:g} s skipped",
        common, options.interval, options.skip));
  }
}

RecordComparison compare_records(const Record& measured, const Record& simulated,
                                 const RecordComparisonOptions& options) {
  require_comparable(measured, simulated.sample_interval, simulated.samples.rows(), options);
  const long common = std::min(measured.samples.rows(), simulated.samples.rows());
  const double per_second = 1.0 / measured.sample_interval;
  const long each = std::lround(options.interval * per_second);
  const long skipped = std::lround(options.skip * per_second);
  const long motion = column_of(measured, simulated.channels.front().name);
  if (motion < 0) {
    throw Error(fmt::format("compare_records: the measured record has no column '{}', the motion",
                            simulated.channels.front().name));
  }
  RecordComparison comparison{options.interval, options.skip, 0.0, {}, {}};
  comparison.motion_correlation =
      correlation(measured.samples.col(motion).head(common), simulated.samples.col(0).head(common));
  const Eigen::VectorXd edge_hz = half_octave_edges(options.lo_hz, std::min(options.hi_hz, 0.5 * per_second));
  for (std::size_t k = 1; k < simulated.channels.size(); ++k) {
    SignalComparison signal;
    signal.name = simulated.channels[k].name;
    signal.quantity = simulated.channels[k].quantity;
    const long m = column_of(measured, signal.name);
    const auto s = static_cast<long>(k);
    if (m < 0) continue;
    const Eigen::VectorXd x = measured.samples.col(m).head(common);
    const Eigen::VectorXd y = simulated.samples.col(s).head(common);
    if (!moves(x) || !moves(y)) {
      comparison.not_compared.push_back(signal.name);
      continue;
    }
    // A last interval of less than half the length says little: it is left out.
    const long intervals = (common + each / 2) / each;
    signal.correlation.resize(intervals);
    for (long i = 0; i < intervals; ++i) {
      const long count = std::min(each, common - i * each);
      signal.correlation[i] = correlation(x.segment(i * each, count), y.segment(i * each, count));
    }
    signal.correlation_of_all = correlation(x.tail(common - skipped), y.tail(common - skipped));
    signal.measured = levels_of(measured, m, skipped, common - skipped, edge_hz);
    signal.simulated = levels_of(simulated, s, skipped, common - skipped, edge_hz);
    signal.level_db = 20.0 * (signal.simulated.rms.array() / signal.measured.rms.array()).log10();
    comparison.signals.push_back(std::move(signal));
  }
  return comparison;
}

}  // namespace struna::ident
