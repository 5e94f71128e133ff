#include "fem/motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "fem/error.hpp"
#include "fem/record_edge.hpp"

namespace struna::fem {

class MotionHistory::Source {
 public:
  virtual ~Source() = default;
  virtual MotionSample at(double t) const = 0;
};

MotionSample MotionHistory::at(double t) const {
  const double slack = 1e-9 * duration_;  // times are sums of steps
  if (!(t >= -slack && t <= duration_ + slack)) {
    throw Error(fmt::format("MotionHistory::at: t must lie in [0, {:g}] s, got {:g}", duration_, t));
  }
  return source_->at(t);
}

namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

/// x = -(a/w^2) sin(phase) with phase' = w, w' = sweep constant, and its exact derivatives.
class Chirp final : public MotionHistory::Source {
 public:
  Chirp(double acceleration, double omega_start, double sweep)
      : acceleration_(acceleration), omega_start_(omega_start), sweep_(sweep) {}

  MotionSample at(double t) const override {
    const double w = omega_start_ + sweep_ * t;
    const double phase = (omega_start_ + 0.5 * sweep_ * t) * t;
    const double s = std::sin(phase);
    const double c = std::cos(phase);
    const double w2 = w * w;
    const double rate = sweep_ / w2;  // relative change of w per radian
    return {-acceleration_ / w2 * s, acceleration_ / w * (2.0 * rate * s - c),
            acceleration_ * ((1.0 - 6.0 * rate * rate) * s + 3.0 * rate * c)};
  }

 private:
  double acceleration_;
  double omega_start_;
  double sweep_;
};

/// Value and three derivatives at a node, in units of the node interval: x, h x', h^2 x'', h^3 x'''.
using Node = std::array<double, 4>;

/// Piecewise polynomial of degree 7 that meets value and three derivatives at every node.
class SepticTable final : public MotionHistory::Source {
 public:
  SepticTable(std::vector<Node> nodes, double interval, bool periodic)
      : nodes_(std::move(nodes)), interval_(interval), periodic_(periodic) {}

  MotionSample at(double t) const override {
    const double u = t / interval_;
    const long last = static_cast<long>(nodes_.size()) - (periodic_ ? 1 : 2);
    long i = static_cast<long>(std::floor(u));
    if (!periodic_) i = std::clamp(i, 0L, last);
    const double z = u - static_cast<double>(i);
    if (periodic_) i = ((i % (last + 1)) + last + 1) % (last + 1);
    const Node& p = nodes_[static_cast<std::size_t>(i)];
    const Node& q = nodes_[periodic_ && i == last ? 0 : static_cast<std::size_t>(i) + 1];
    return evaluate(p, q, z);
  }

 private:
  MotionSample evaluate(const Node& p, const Node& q, double z) const {
    // Taylor polynomial at the left node; the remaining coefficients take up what is missing at the right
    // one.
    const double a2 = 0.5 * p[2];
    const double a3 = p[3] / 6.0;
    const double r0 = q[0] - (p[0] + p[1] + a2 + a3);
    const double r1 = q[1] - (p[1] + p[2] + 3.0 * a3);
    const double r2 = q[2] - (p[2] + p[3]);
    const double r3 = q[3] - p[3];
    const double a4 = 35.0 * r0 - 15.0 * r1 + 2.5 * r2 - r3 / 6.0;
    const double a5 = -84.0 * r0 + 39.0 * r1 - 7.0 * r2 + 0.5 * r3;
    const double a6 = 70.0 * r0 - 34.0 * r1 + 6.5 * r2 - 0.5 * r3;
    const double a7 = -20.0 * r0 + 10.0 * r1 - 2.0 * r2 + r3 / 6.0;
    const double x = p[0] + z * (p[1] + z * (a2 + z * (a3 + z * (a4 + z * (a5 + z * (a6 + z * a7))))));
    const double v =
        p[1] + z * (p[2] + z * (3 * a3 + z * (4 * a4 + z * (5 * a5 + z * (6 * a6 + z * 7 * a7)))));
    const double a = p[2] + z * (6 * a3 + z * (12 * a4 + z * (20 * a5 + z * (30 * a6 + z * 42 * a7))));
    return {x, v / interval_, a / (interval_ * interval_)};
  }

  std::vector<Node> nodes_;
  double interval_;
  bool periodic_;
};

/// Nodes per shortest period: the septic's error in the acceleration is (w h)^6/3.2e5, below 1e-9 at 24 and
/// more.
constexpr double nodes_per_period = 24.0;

/// Uniform in (0, 1): the 53 upper bits, so that it is the same on every machine (std's distributions are
/// not).
double uniform(std::mt19937_64& generator) {
  return (static_cast<double>(generator() >> 11) + 0.5) * 0x1.0p-53;
}

struct LineSpectrum {
  double period = 0.0;                               ///< [s]; line k lies at k/period
  long first = 0;                                    ///< k of the first line
  std::vector<std::complex<double>> acceleration{};  ///< amplitudes, x'' = Re sum A_k exp(i w_k t)
};

/// Two real series at once: f + i g with f = Re sum F_k e^{i w_k t}, g likewise.
std::vector<std::complex<double>> synthesise(const LineSpectrum& lines, std::size_t nodes, int power_f,
                                             int power_g) {
  std::vector<std::complex<double>> spectrum(nodes);
  std::vector<std::complex<double>> series(nodes);
  const std::complex<double> i(0.0, 1.0);
  for (std::size_t n = 0; n < lines.acceleration.size(); ++n) {
    const auto k = static_cast<std::size_t>(lines.first) + n;
    const std::complex<double> iwh = i * two_pi * static_cast<double>(k) / static_cast<double>(nodes);
    const auto f = 0.5 * lines.acceleration[n] * std::pow(iwh, power_f);
    const auto g = 0.5 * lines.acceleration[n] * std::pow(iwh, power_g);
    spectrum[k] += f + i * g;
    spectrum[nodes - k] += std::conj(f) + i * std::conj(g);
  }
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::Unscaled);
  fft.inv(series, spectrum);
  return series;
}

/// The table of a line spectrum over its period; `nodes` a power of two.
std::vector<Node> periodic_nodes(const LineSpectrum& lines, std::size_t nodes) {
  const double h = lines.period / static_cast<double>(nodes);
  const auto even = synthesise(lines, nodes, -2, -1);  // x and h x', from x'' by powers of i w h
  const auto odd = synthesise(lines, nodes, 0, 1);     // h^2 x'' and h^3 x'''
  std::vector<Node> table(nodes);
  for (std::size_t n = 0; n < nodes; ++n) {
    table[n] = {even[n].real(), even[n].imag(), odd[n].real(), odd[n].imag()};
    for (double& value : table[n]) value *= h * h;
  }
  return table;
}

void scale(std::vector<Node>& nodes, double factor) {
  for (auto& node : nodes) {
    for (double& value : node) value *= factor;
  }
}

/// rms acceleration over the first `count` nodes.
double rms_acceleration(const std::vector<Node>& nodes, std::size_t count, double interval) {
  double sum = 0.0;
  for (std::size_t n = 0; n < count; ++n) sum += nodes[n][2] * nodes[n][2];
  return std::sqrt(sum / static_cast<double>(count)) / (interval * interval);
}

LineSpectrum draw_lines(const Excitation& excitation, double period) {
  const double rounding = 1e-9;  // so that a line meant to lie on the band's edge does
  const auto first = static_cast<long>(std::ceil(excitation.band_lo_hz * period - rounding));
  const auto last = static_cast<long>(std::floor(excitation.band_hi_hz * period + rounding));
  if (last < first) {
    throw Error(fmt::format(
        "motion_history: the band {:g}-{:g} Hz holds no multiple of {:g} Hz (a longer duration has more)",
        excitation.band_lo_hz, excitation.band_hi_hz, 1.0 / period));
  }
  const bool gaussian = excitation.kind == Excitation::Kind::random;
  std::mt19937_64 generator(excitation.seed);
  LineSpectrum lines{period, first, {}};
  for (long k = first; k <= last; ++k) {
    const double amplitude = gaussian ? std::sqrt(-2.0 * std::log(uniform(generator))) : 1.0;
    lines.acceleration.push_back(std::polar(amplitude, two_pi * uniform(generator)));
  }
  return lines;
}

std::size_t power_of_two_above(double x) {
  return std::size_t{1} << static_cast<int>(std::ceil(std::log2(x)));
}

MotionHistory line_motion(const Excitation& excitation, double duration) {
  const bool random = excitation.kind == Excitation::Kind::random;
  const double rate = nodes_per_period * excitation.band_hi_hz;  // [1/s]
  const double shortest = random ? 1.2 * duration : multisine_period(duration);
  const std::size_t nodes = power_of_two_above(std::max(64.0, shortest * rate));
  const double period = random ? std::max(static_cast<double>(nodes) / rate, shortest) : shortest;
  const double interval = period / static_cast<double>(nodes);
  auto table = periodic_nodes(draw_lines(excitation, period), nodes);
  const std::size_t counted =
      random ? std::min(nodes, static_cast<std::size_t>(duration / interval) + 1) : nodes;
  scale(table, excitation.rms_acceleration / rms_acceleration(table, counted, interval));
  return {std::make_shared<SepticTable>(std::move(table), interval, true), duration, excitation.band_hi_hz};
}

void require_positive(double value, const char* name) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw Error(fmt::format("motion_history: {} must be positive and finite, got {:g}", name, value));
  }
}

void require_band(const Excitation& excitation) {
  require_positive(excitation.band_lo_hz, "the band's lower edge [Hz]");
  require_positive(excitation.band_hi_hz, "the band's upper edge [Hz]");
  if (excitation.band_hi_hz <= excitation.band_lo_hz) {
    throw Error(fmt::format("motion_history: the band must rise, got {:g} to {:g} Hz", excitation.band_lo_hz,
                            excitation.band_hi_hz));
  }
}

/// Coefficients of the interpolating B-spline of degree 7, by its recursive filters: Unser, IEEE Signal
/// Process. Mag. 16(6) (1999) 22, table 1 and eqs. 21-22. `margin` samples are added at either end, by point
/// reflection.
std::vector<double> spline_coefficients(const Eigen::VectorXd& samples, long margin) {
  const long count = samples.size();
  const auto continued = [&](long i) {
    double offset = 0.0;
    double sign = 1.0;
    while (i < 0 || i >= count) {  // x(end + k) = 2 x(end) - x(end - k)
      const long end = i < 0 ? 0 : count - 1;
      offset += sign * 2.0 * samples[end];
      sign = -sign;
      i = 2 * end - i;
    }
    return offset + sign * samples[i];
  };
  std::vector<double> c(static_cast<std::size_t>(count + 2 * margin));
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = continued(static_cast<long>(i) - margin);
  for (const double pole : {-0.53528043079643816554, -0.12255461519232669052, -0.0091486948096082769286}) {
    const double gain = (1.0 - pole) * (1.0 - 1.0 / pole);
    for (double& value : c) value *= gain;
    for (std::size_t i = 1; i < c.size(); ++i) c[i] += pole * c[i - 1];
    c.back() *= -pole / (1.0 - pole * pole);
    for (std::size_t i = c.size() - 1; i-- > 0;) c[i] = pole * (c[i + 1] - c[i]);
  }
  return c;
}

/// Value and derivatives of the degree-7 B-spline series at a knot.
Node spline_node(const double* c) {
  const double s1 = c[1] + c[-1];
  const double s2 = c[2] + c[-2];
  const double s3 = c[3] + c[-3];
  const double d1 = c[1] - c[-1];
  const double d2 = c[2] - c[-2];
  const double d3 = c[3] - c[-3];
  return {(2416.0 * c[0] + 1191.0 * s1 + 120.0 * s2 + s3) / 5040.0, (245.0 * d1 + 56.0 * d2 + d3) / 720.0,
          (-80.0 * c[0] + 15.0 * s1 + 24.0 * s2 + s3) / 120.0, (-19.0 * d1 + 8.0 * d2 + d3) / 24.0};
}

}  // namespace

double multisine_period(double duration) {
  return 0.5 * duration;
}

MotionHistory motion_history(const Excitation& excitation, double duration) {
  require_positive(duration, "the duration [s]");
  switch (excitation.kind) {
    case Excitation::Kind::sine: {
      require_positive(excitation.frequency_hz, "the sine's frequency [Hz]");
      require_positive(excitation.acceleration, "the acceleration [m/s^2]");
      const double omega = two_pi * excitation.frequency_hz;
      return {std::make_shared<Chirp>(excitation.acceleration, omega, 0.0), duration,
              excitation.frequency_hz};
    }
    case Excitation::Kind::chirp: {
      require_band(excitation);
      require_positive(excitation.acceleration, "the acceleration [m/s^2]");
      const double sweep = two_pi * (excitation.band_hi_hz - excitation.band_lo_hz) / duration;
      return {std::make_shared<Chirp>(excitation.acceleration, two_pi * excitation.band_lo_hz, sweep),
              duration, excitation.band_hi_hz};
    }
    case Excitation::Kind::random:
    case Excitation::Kind::multisine:
      require_band(excitation);
      require_positive(excitation.rms_acceleration, "the rms acceleration [m/s^2]");
      return line_motion(excitation, duration);
    case Excitation::Kind::record:
      break;
  }
  throw Error("motion_history: a record's motion comes from its samples, see motion_from_samples");
}

MotionHistory motion_from_samples(const Eigen::VectorXd& samples, double sample_interval) {
  require_positive(sample_interval, "the sample interval [s]");
  if (samples.size() < 8) {
    throw Error(fmt::format("motion_from_samples: at least 8 samples, got {}", samples.size()));
  }
  for (long i = 0; i < samples.size(); ++i) {
    if (!std::isfinite(samples[i])) {
      throw Error(fmt::format("motion_from_samples: samples must be finite, sample {} is not", i));
    }
  }
  Eigen::VectorXd sound = samples;
  std::string note;
  if (const auto edge = find_resampling_edge(samples, sample_interval)) {
    const long repaired = edge->repaired.size();
    sound.head(repaired) = edge->repaired;
    note = fmt::format(
        "the record starts with a jump, the edge of a resampling by 1:{} with zeros before its start: its "
        "first {} samples were reconstructed (to {:.1g})",
        edge->factor, repaired, edge->uncertainty);
  }
  constexpr long margin = 64;  // the slowest filter pole to this power is below rounding
  const auto coefficients = spline_coefficients(sound, margin);
  std::vector<Node> nodes;
  nodes.reserve(static_cast<std::size_t>(samples.size()));
  for (long i = 0; i < samples.size(); ++i)
    nodes.push_back(spline_node(&coefficients[static_cast<std::size_t>(i + margin)]));
  const double duration = static_cast<double>(samples.size() - 1) * sample_interval;
  return {std::make_shared<SepticTable>(std::move(nodes), sample_interval, false), duration,
          0.5 / sample_interval, note};
}

}  // namespace struna::fem
