#include "ident/resonance_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace struna::ident {
namespace {

// Fall on either side of a peak that makes it one: in standard deviations of the top's and of the valley's
// line (the extremes of noise over many lines lie three apart from the mean, and sigma is itself uncertain),
// and as a share of the peak.
constexpr double least_drop_sigma = 5.0, least_drop_share = 0.15;
constexpr double stands_out = 12.0;  // standard deviations

double line_spacing(const TransferFunction& tf) {
  return (tf.frequency_hz(tf.lines() - 1) - tf.frequency_hz(0)) / static_cast<double>(tf.lines() - 1);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median of each line and its neighbours: a spike on one line (mains hum, a quotient of noise) is no
// resonance, whose flanks take in the neighbours even where lines are coarse.
Eigen::VectorXd without_spikes(const Eigen::VectorXd& values) {
  Eigen::VectorXd result = values;
  for (long i = 1; i + 1 < values.size(); ++i) result(i) = median({values(i - 1), values(i), values(i + 1)});
  return result;
}

// Square of the magnitude over all outputs, each in units of its median, less what the noise adds to it on
// average; and half of its standard deviation where outputs share their noise (that of the input), which is
// the worst case.
struct Power {
  Eigen::VectorXd value;
  Eigen::VectorXd half_sigma;
};
Power power_of(const TransferFunction& tf) {
  Eigen::ArrayXd power = Eigen::ArrayXd::Zero(tf.lines()), noise = power, half_sigma = power;
  for (const auto& output : tf.outputs) {
    const Eigen::ArrayXd size = output.value.cwiseAbs();
    const double unit = median({size.data(), size.data() + size.size()});
    if (!(unit > 0.0)) continue;
    power += (size / unit).square();
    noise += 2.0 * (output.sigma.array() / unit).square();
    half_sigma += size * output.sigma.array() / (unit * unit);
  }
  return {without_spikes(power - noise), half_sigma};
}

// Root of the mean power over 2 m + 1 lines (fewer towards the ends) and its standard deviation.
struct Magnitude {
  Eigen::VectorXd value;
  Eigen::VectorXd sigma;
};
Magnitude magnitude_of(const Power& power, long m) {
  const auto mean = [m](const Eigen::VectorXd& values) {
    const long n = values.size();
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n + 1), result(n);
    for (long i = 0; i < n; ++i) sum(i + 1) = sum(i) + values(i);
    for (long i = 0; i < n; ++i) {
      const long reach = std::min({m, i, n - 1 - i});
      result(i) = (sum(i + reach + 1) - sum(i - reach)) / static_cast<double>(2 * reach + 1);
    }
    return result;
  };
  const Eigen::ArrayXd value = mean(power.value).cwiseMax(0.0).cwiseSqrt();
  const Eigen::ArrayXd half_sigma = mean(power.half_sigma.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  Eigen::ArrayXd sigma = half_sigma / value.max(half_sigma.sqrt()).max(1e-300);
  for (long i = 0, n = sigma.size(); i < n; ++i)
    sigma(i) /= std::sqrt(static_cast<double>(2 * std::min({m, i, n - 1 - i}) + 1));
  return {value, sigma};
}

// Tops from which y falls far enough on either side, by hysteresis. A top must stand out of the noise, and a
// valley is where y is surely low, not where a line is unknown: else lines without excitation would hide all
// that follows.
std::vector<long> tops(const Magnitude& y) {
  const auto surely_below = [&](long valley, long top) {
    return y.value(top) - y.value(valley) >
           std::max(least_drop_sigma * (y.sigma(top) + y.sigma(valley)), least_drop_share * y.value(top));
  };
  const auto upper_bound = [&](long i) { return y.value(i) + least_drop_sigma * y.sigma(i); };
  const auto stands = [&](long i) { return y.value(i) > stands_out * y.sigma(i); };
  std::vector<long> found;
  long top = stands(0) ? 0 : -1, bottom = 0;
  for (long i = 1; i < y.value.size(); ++i) {
    if (top >= 0) {  // rising, or falling slowly
      if (stands(i) && y.value(i) > y.value(top)) top = i;
      if (!surely_below(i, top)) continue;
      if (top > 0) found.push_back(top);
      top = -1;
      bottom = i;
    } else {
      if (upper_bound(i) < upper_bound(bottom)) bottom = i;
      if (stands(i) && surely_below(bottom, i)) top = i;
    }
  }
  return found;
}

// Lines from `peak` to where y falls below 1/sqrt(2) of it going by `step`, or 0 where it rises above the
// peak or ends before.
long lines_to_half_power(const Eigen::VectorXd& y, long peak, long step) {
  for (long i = peak + step; i >= 0 && i < y.size() && y(i) <= y(peak); i += step)
    if (y(i) < std::numbers::sqrt2 / 2.0 * y(peak)) return std::abs(i - peak);
  return 0;
}

Pole pole_at(const TransferFunction& tf, const Eigen::VectorXd& y, long peak) {
  const long left = lines_to_half_power(y, peak, -1), right = lines_to_half_power(y, peak, 1);
  const long flank = left > 0 && right > 0 ? std::min(left, right) : std::max({left, right, 1L});
  const double f = tf.frequency_hz(peak);
  const double bandwidth = std::max(1.0, 2.0 * (static_cast<double>(flank) - 0.5)) * line_spacing(tf);
  return {f, std::min(bandwidth / f, 0.4)};
}

// The residual over sigma and 1/sigma^2, added up over more and more lines.
struct Pyramid {
  Eigen::VectorXd group_hz;  // middle of each group of lines
  Eigen::MatrixXcd product;  // groups x outputs
  Eigen::MatrixXd power;
  double spacing;

  Pyramid(const TransferFunction& tf, const Eigen::MatrixXcd& residual)
      : group_hz(tf.frequency_hz),
        product(residual),
        power(residual.rows(), residual.cols()),
        spacing(line_spacing(tf)) {
    for (long k = 0; k < residual.cols(); ++k) {
      const Eigen::VectorXd inverse = tf.outputs[static_cast<std::size_t>(k)].sigma.cwiseInverse();
      product.col(k) = product.col(k).cwiseProduct(inverse);
      power.col(k) = inverse.cwiseAbs2();
    }
  }

  void halve() {
    const long n = group_hz.size() / 2;
    for (long i = 0; i < n; ++i) {
      group_hz(i) = 0.5 * (group_hz(2 * i) + group_hz(2 * i + 1));
      product.row(i) = product.row(2 * i) + product.row(2 * i + 1);
      power.row(i) = power.row(2 * i) + power.row(2 * i + 1);
    }
    group_hz.conservativeResize(n);
    product.conservativeResize(n, Eigen::NoChange);
    power.conservativeResize(n, Eigen::NoChange);
    spacing *= 2.0;
  }

  // What a pole at group `centre` takes out of the sum of squares, its constants free.
  double gain(const Eigen::VectorXcd& filter, long centre) const {
    const long half = filter.size() / 2;
    const long first = std::max(0L, centre - half), last = std::min(group_hz.size() - 1, centre + half);
    const auto part = filter.segment(first - centre + half, last - first + 1);
    double sum = 0.0;
    for (long k = 0; k < product.cols(); ++k) {
      const double norm = part.cwiseAbs2().dot(power.col(k).segment(first, last - first + 1));
      sum += std::norm(part.dot(product.col(k).segment(first, last - first + 1))) / norm;
    }
    return sum;
  }
};

// 1/(x + i) over three bandwidths either side.
Eigen::VectorXcd resonance_filter(double bandwidth_lines) {
  const long half = static_cast<long>(std::ceil(3.0 * bandwidth_lines));
  Eigen::VectorXcd filter(2 * half + 1);
  for (long j = -half; j <= half; ++j)
    filter(j + half) = 1.0 / std::complex<double>(-2.0 * static_cast<double>(j) / bandwidth_lines, 1.0);
  return filter;
}

}  // namespace

std::vector<Pole> find_peaks(const TransferFunction& tf) {
  const Power power = power_of(tf);
  // From fine to coarse: what noise hides on the single line shows in the mean over many.
  std::vector<Pole> poles;
  for (long m = 0; 2 * m + 1 <= tf.lines() / 8 || m == 0; m = 3 * m + 1) {
    const Magnitude y = magnitude_of(power, m);
    for (const long peak : tops(y)) {
      const Pole pole = pole_at(tf, y.value, peak);
      const bool known = std::any_of(poles.begin(), poles.end(), [&](const Pole& other) {
        return std::abs(other.natural_frequency_hz - pole.natural_frequency_hz) <
               std::max(bandwidth_hz(other), bandwidth_hz(pole));
      });
      if (!known) poles.push_back(pole);
    }
  }
  std::sort(poles.begin(), poles.end(),
            [](const Pole& a, const Pole& b) { return a.natural_frequency_hz < b.natural_frequency_hz; });
  return poles;
}

std::optional<ResidualPole> strongest_pole(const TransferFunction& tf, const Eigen::MatrixXcd& residual,
                                           double lo_hz, double hi_hz, const std::vector<Pole>& tried,
                                           double least_gain) {
  const auto skipped = [&](double f) {
    return f < lo_hz || f > hi_hz || std::any_of(tried.begin(), tried.end(), [&](const Pole& other) {
             return std::abs(other.natural_frequency_hz - f) < bandwidth_hz(other);
           });
  };
  std::optional<ResidualPole> best;
  Pyramid level(tf, residual);
  for (double bandwidth = 2.0 * level.spacing; bandwidth < 0.3 * hi_hz; bandwidth *= 2.0) {
    if (bandwidth > 7.9 * level.spacing) level.halve();
    const Eigen::VectorXcd filter = resonance_filter(bandwidth / level.spacing);
    if (level.group_hz.size() < 2) break;
    for (long centre = 0; centre < level.group_hz.size(); ++centre) {
      const double f = level.group_hz(centre);
      if (bandwidth > 0.3 * f || skipped(f)) continue;
      const double gain = level.gain(filter, centre);
      if (gain > least_gain && (!best || gain > best->gain)) best = ResidualPole{{f, bandwidth / f}, gain};
    }
  }
  return best;
}

}  // namespace struna::ident
