#include "fem/smooth_curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "fem/band_cholesky.hpp"
#include "fem/error.hpp"

namespace struna::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr long states = 3;
constexpr std::size_t fewest = 5;
constexpr double end_weight = 1e4;  // of a true end: a hundred times truer than the points between
constexpr double directions = 2.0;  // across the curve
constexpr double nearest = 0.05;    // of the mean chord
// Intensity of the process over the variance of the points. At 40 third differences are of both alike.
constexpr double smoothest = 1e-7, roughest = 1e4;

/// What is smoothed: parameters, what was seen there, and its weight.
struct Data {
  std::vector<double> t;
  Points point;
  std::vector<double> weight;

  void add(double at, const Vector3d& seen, double w) {
    t.push_back(at);
    point.push_back(seen);
    weight.push_back(w);
  }
  void drop() {
    t.pop_back();
    point.pop_back();
    weight.pop_back();
  }
};

Data data_of(const Points& points) {
  std::vector<double> sum{0.0};
  for (std::size_t i = 1; i < points.size(); ++i)
    sum.push_back(sum.back() + (points[i] - points[i - 1]).norm());
  const double mean = sum.back() / static_cast<double>(points.size() - 1);
  Data data;
  data.add(0.0, points.front(), end_weight);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double t = sum[i] / mean;
    if (t - data.t.back() >= nearest) {
      data.add(t, points[i], 1.0);
    } else if (data.t.size() > 1) {
      const double w = data.weight.back();
      data.point.back() = (w * data.point.back() + points[i]) / (w + 1.0);
      data.weight.back() = w + 1.0;
    }
  }
  const double end = sum.back() / mean;
  if (data.t.size() > 1 && end - data.t.back() < nearest) data.drop();
  data.add(end, points.back(), end_weight);
  return data;
}

/// From a state to that a step h later, along an arc that turns by `turn` in a unit step.
Matrix3d transition(double h, double turn) {
  const double a = turn * h;
  const bool small = a < 1e-4;
  const double sine = small ? 1.0 - a * a / 6.0 : std::sin(a) / a;                            // sin a/a
  const double rest = small ? 0.5 - a * a / 24.0 : 2.0 * std::pow(std::sin(0.5 * a) / a, 2);  // (1-cos a)/a^2
  return (Matrix3d() << 1.0, h * sine, h * h * rest, 0.0, std::cos(a), h * sine, 0.0, -turn * a * sine,
          std::cos(a))
      .finished();
}

/// Inverse of the covariance of what the process adds to a state over a step h, at unit intensity.
Matrix3d precision(double h) {
  const double h2 = h * h, h3 = h2 * h, h4 = h3 * h, h5 = h4 * h;
  return (Matrix3d() << 720.0 / h5, -360.0 / h4, 60.0 / h3, -360.0 / h4, 192.0 / h3, -36.0 / h2, 60.0 / h3,
          -36.0 / h2, 9.0 / h)
      .finished();
}

void add_block(BandMatrix& a, std::size_t row, std::size_t col, const Matrix3d& block) {
  for (long i = 0; i < states; ++i) {
    for (long j = 0; j < states; ++j) {
      const long r = states * static_cast<long>(row) + i, c = states * static_cast<long>(col) + j;
      if (r >= c) a.lower(r - c, c) += block(i, j);
    }
  }
}

/// The states' posterior for one ratio after another. All precisions are in units of 1/scatter^2.
class Smoother {
 public:
  explicit Smoother(const Points& points) : data_(data_of(points)) {
    if (data_.t.size() < fewest)
      throw Error(
          fmt::format("curves_through: at least {} points that are apart, got {}", fewest, data_.t.size()));
    weight_ = zeros();
    for (std::size_t i = 0; i < data_.t.size(); ++i)
      weight_.lower(0, states * static_cast<long>(i)) = data_.weight[i];
    follow(std::vector<double>(data_.t.size() - 1, 0.0));
  }

  /// Takes the turn of each step for what arcs do.
  void follow(const std::vector<double>& turn) {
    turn_ = turn;
    process_ = zeros();
    for (std::size_t i = 1; i < data_.t.size(); ++i) {
      const Matrix3d f = transition(step(i), turn_[i - 1]), p = precision(step(i));
      add_block(process_, i - 1, i - 1, f.transpose() * p * f);
      add_block(process_, i, i - 1, -p * f);
      add_block(process_, i, i, p);
    }
  }

  /// The likeliest curve at this ratio is kept; returns -2 ln of the ratio's restricted likelihood.
  double solve(double ratio) {
    if (!factor_.factorise(process_, 1.0 / ratio, weight_, 1.0))
      throw Error("curves_through: chords must not differ in length by so much");
    const std::size_t n = data_.t.size();
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(weight_.size(), 3);
    for (std::size_t i = 0; i < n; ++i)
      x.row(states * static_cast<long>(i)) = data_.weight[i] * data_.point[i].transpose();
    for (long c = 0; c < 3; ++c) factor_.solve(x.col(c));
    curve_.t = data_.t;
    curve_.state.resize(n);
    for (std::size_t i = 0; i < n; ++i)
      curve_.state[i] = x.middleRows(states * static_cast<long>(i), states).transpose();
    const double cost = misfit() + roughness() / ratio;
    curve_.scatter = std::sqrt(cost / freedom());
    const double added = static_cast<double>(states) * static_cast<double>(n - 1) * std::log(ratio);
    // A straight line fits to rounding: no ratio is likelier than another.
    return freedom() * std::log(std::max(cost, 1e-300)) + directions * (factor_.log_determinant() + added);
  }

  /// A curve drawn from those that are possible at this ratio.
  SmoothCurve drawn(double ratio, std::mt19937_64& engine) {
    solve(ratio);
    SmoothCurve result = curve_;
    result.scatter *= std::sqrt(freedom() / std::chi_squared_distribution<double>(freedom())(engine));
    std::normal_distribution<double> normal;
    for (long c = 0; c < 3; ++c) {
      Eigen::VectorXd x(weight_.size());
      for (double& value : x) value = normal(engine);
      factor_.colour(x);
      for (std::size_t i = 0; i < result.state.size(); ++i)
        result.state[i].row(c) +=
            result.scatter * x.segment(states * static_cast<long>(i), states).transpose();
    }
    return result;
  }

  const SmoothCurve& curve() const { return curve_; }
  double step(std::size_t i) const { return data_.t[i] - data_.t[i - 1]; }

 private:
  BandMatrix zeros() const {
    return {Eigen::MatrixXd::Zero(2 * states, states * static_cast<long>(data_.t.size()))};
  }
  /// Of the scatter: a parabola would fit three points.
  double freedom() const { return directions * static_cast<double>(data_.t.size() - 3); }
  double misfit() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < data_.t.size(); ++i)
      sum += data_.weight[i] * (data_.point[i] - curve_.state[i].col(0)).squaredNorm();
    return sum;
  }
  double roughness() const {
    double sum = 0.0;
    for (std::size_t i = 1; i < data_.t.size(); ++i) {
      const Matrix3d added =
          curve_.state[i] - curve_.state[i - 1] * transition(step(i), turn_[i - 1]).transpose();
      sum += (added * precision(step(i))).cwiseProduct(added).sum();
    }
    return sum;
  }

  Data data_;
  BandMatrix process_, weight_;
  std::vector<double> turn_;
  SmoothCurve curve_;
  BandCholesky factor_;
};

/// Ratios, equally far apart in their logarithm, and how likely they are.
struct Likelihood {
  std::vector<double> ratio;
  std::vector<double> share;  ///< of the likelihood up to and with each

  double likeliest = 0.0;
  double quantile(double of) const {
    const auto at = std::lower_bound(share.begin(), share.end() - 1, of);
    return ratio[static_cast<std::size_t>(at - share.begin())];
  }
};

Likelihood likelihood(Smoother& smoother, int steps) {
  Likelihood result;
  std::vector<double> cost;
  for (int k = 0; k <= steps; ++k) {
    result.ratio.push_back(smoothest * std::pow(roughest / smoothest, static_cast<double>(k) / steps));
    cost.push_back(smoother.solve(result.ratio.back()));
  }
  const auto best = std::min_element(cost.begin(), cost.end());
  result.likeliest = result.ratio[static_cast<std::size_t>(best - cost.begin())];
  double sum = 0.0;
  for (const double c : cost) result.share.push_back(sum += std::exp(0.5 * (*best - c)));
  for (double& share : result.share) share /= sum;
  return result;
}

/// How far the curve turns in a unit of t, mean over each step.
std::vector<double> turn_of_steps(const SmoothCurve& curve) {
  std::vector<double> at;
  for (const Matrix3d& s : curve.state) {
    const double speed2 = s.col(1).squaredNorm();
    at.push_back((s.col(2) - s.col(1) * (s.col(1).dot(s.col(2)) / speed2)).norm() / std::sqrt(speed2));
  }
  std::vector<double> mean;
  for (std::size_t i = 1; i < at.size(); ++i) mean.push_back(0.5 * (at[i - 1] + at[i]));
  return mean;
}

}  // namespace

Vector3d SmoothCurve::at(double where) const {
  const auto after = std::upper_bound(t.begin() + 1, t.end() - 1, where);
  const auto i = static_cast<std::size_t>(after - t.begin()) - 1;
  const double h = t[i + 1] - t[i], u = where - t[i], v = u / h;
  // What the next state has beyond the parabola from this one, taken up by v^3, v^4 and v^5.
  const Matrix3d added = state[i + 1] - state[i] * transition(h, 0.0).transpose();
  const Vector3d a = added.col(0), b = h * added.col(1), c = h * h * added.col(2);
  return state[i].col(0) + u * (state[i].col(1) + 0.5 * u * state[i].col(2)) +
         v * v * v *
             ((10.0 * a - 4.0 * b + 0.5 * c) +
              v * ((-15.0 * a + 7.0 * b - c) + v * (6.0 * a - 3.0 * b + 0.5 * c)));
}

CurvesThroughPoints curves_through(const Points& points, int draws) {
  constexpr int first_steps = 14, steps = 40;
  Smoother smoother(points);
  // Bends as a curve without them shows them; then the curve that has them.
  smoother.solve(likelihood(smoother, first_steps).likeliest);
  const std::vector<double> turn = turn_of_steps(smoother.curve());
  smoother.follow(turn);
  const Likelihood likely = likelihood(smoother, steps);
  CurvesThroughPoints result;
  std::mt19937_64 engine(1);
  for (int k = 0; k < draws; ++k)
    result.drawn.push_back(smoother.drawn(likely.quantile((k + 0.5) / draws), engine));
  smoother.solve(likely.likeliest);
  result.likeliest = smoother.curve();
  for (std::size_t i = 0; i < turn.size(); ++i) result.turn += turn[i] * smoother.step(i + 1);
  return result;
}

Centreline centreline_along(const SmoothCurve& curve, double length) {
  // The natural spline through these is straight at its ends: its last steps are short.
  constexpr int pieces = 60;
  const double end = curve.t.back(), step = end / pieces;
  Points points;
  for (const double u : {0.0, 0.04, 0.15, 0.4}) points.push_back(curve.at(u * step));
  for (int i = 1; i < pieces; ++i) points.push_back(curve.at(i * step));
  for (const double u : {0.4, 0.15, 0.04, 0.0}) points.push_back(curve.at(end - u * step));
  return spline_through(points, length);
}

}  // namespace struna::fem
