#include "fem/centreline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fem/centreline_curve.hpp"
#include "fem/error.hpp"
#include "fem/quadrature.hpp"

namespace struna::fem {

namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

std::string text(const Vector3d& v) {
  return fmt::format("({:g}, {:g}, {:g})", v.x(), v.y(), v.z());
}

class Line final : public Centreline::Curve {
 public:
  Line(const Vector3d& from, const Vector3d& to)
      : from_(from), tangent_((to - from).normalized()), length_((to - from).norm()) {}
  double length() const override { return length_; }
  CurvePoint at(double s) const override { return {from_ + s * tangent_, tangent_, Vector3d::Zero()}; }
  bool is_straight() const override { return true; }

 private:
  Vector3d from_;
  Vector3d tangent_;
  double length_;
};

class Arc final : public Centreline::Curve {
 public:
  Arc(double length, double angle) : length_(length), radius_(length / angle) {}
  double length() const override { return length_; }
  CurvePoint at(double s) const override {
    const double phi = s / radius_;
    const double half = std::sin(0.5 * phi);
    return {radius_ * Vector3d(std::sin(phi), 2.0 * half * half, 0.0),
            Vector3d(std::cos(phi), std::sin(phi), 0.0),
            Vector3d(-std::sin(phi), std::cos(phi), 0.0) / radius_};
  }

 private:
  double length_;
  double radius_;
};

/// One cubic r(t) = c0 + c1 t + c2 t^2 + c3 t^3, t from 0 to `chord`.
struct Cubic {
  std::array<Vector3d, 4> c;
  double chord = 0.0;

  Vector3d position(double t) const { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); }
  Vector3d slope(double t) const { return c[1] + t * (2.0 * c[2] + t * (3.0 * c[3])); }
  Vector3d second(double t) const { return 2.0 * c[2] + 6.0 * t * c[3]; }
  double speed(double t) const { return slope(t).norm(); }
};

/// Second derivatives at the knots of the natural cubic spline, by the tridiagonal system (de Boor, ch. IV).
Points natural_second_derivatives(const Points& points, const std::vector<double>& chord) {
  const std::size_t n = points.size();
  Points second(n, Vector3d::Zero());
  if (n < 3) return second;
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Vector3d bend =
        6.0 * ((points[i + 1] - points[i]) / chord[i] - (points[i] - points[i - 1]) / chord[i - 1]);
    const double pivot = 2.0 * (chord[i - 1] + chord[i]) - chord[i - 1] * upper[i - 1];
    upper[i] = chord[i] / pivot;
    second[i] = (bend - chord[i - 1] * second[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i > 0; --i) second[i] -= upper[i] * second[i + 1];
  return second;
}

std::vector<Cubic> natural_spline(const Points& points) {
  std::vector<double> chord;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) chord.push_back((points[i + 1] - points[i]).norm());
  const Points second = natural_second_derivatives(points, chord);
  std::vector<Cubic> cubics;
  for (std::size_t i = 0; i < chord.size(); ++i) {
    const double h = chord[i];
    cubics.push_back(
        {{points[i], (points[i + 1] - points[i]) / h - h / 6.0 * (2.0 * second[i] + second[i + 1]),
          0.5 * second[i], (second[i + 1] - second[i]) / (6.0 * h)},
         h});
  }
  return cubics;
}

/// A spline by arc length. Arc length comes from Gauss quadrature of the speed; its inverse t(s) is kept as
/// Chebyshev series over pieces, halved until the series meets the arc length to rounding, so that a look-up
/// costs one short sum.
class Spline final : public Centreline::Curve {
 public:
  explicit Spline(const Points& points) : cubics_(natural_spline(points)), rule_(gauss_legendre(16)) {
    for (const Cubic& cubic : cubics_) scale_ += cubic.chord;
    for (std::size_t i = 0; i < cubics_.size(); ++i) add_pieces(i, 0.0, cubics_[i].chord, 0);
  }

  double length() const override { return length_; }

  CurvePoint at(double s) const override {
    const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), s,
                                        [](double value, const Piece& piece) { return value < piece.s; });
    const Piece& piece = after == pieces_.begin() ? *after : *(after - 1);
    const Cubic& cubic = cubics_[piece.cubic];
    const double t = piece.t + chebyshev(piece.inverse, 2.0 * (s - piece.s) / piece.length - 1.0);
    const Vector3d slope = cubic.slope(t);
    const Vector3d second = cubic.second(t);
    const double speed2 = slope.squaredNorm();
    return {cubic.position(t), slope / std::sqrt(speed2),
            (second - slope * (slope.dot(second) / speed2)) / speed2};
  }

 private:
  static constexpr int terms = 14;  ///< even
  using Series = std::array<double, terms>;

  struct Piece {
    double s = 0.0;       ///< arc length at its start
    double length = 0.0;  ///< arc length of the piece
    double t = 0.0;       ///< parameter at its start
    std::size_t cubic = 0;
    Series inverse{};  ///< t - piece.t over arc length, Chebyshev
  };

  /// Clenshaw's sum over the even and the odd terms side by side: T_2k and T_2k+1 obey the recurrence of T_k
  /// with 2 x^2 - 1 for x, and two short chains of operations are sooner done than a long one.
  static double chebyshev(const Series& series, double x) {
    const double two_y = 4.0 * x * x - 2.0;
    Eigen::Array2d b1 = Eigen::Array2d::Zero();
    Eigen::Array2d b2 = Eigen::Array2d::Zero();
    for (std::size_t k = terms - 2; k > 0; k -= 2) {
      const Eigen::Array2d b = two_y * b1 + (Eigen::Array2d::Map(&series[k]) - b2);
      b2 = b1;
      b1 = b;
    }
    const double even = 0.5 * two_y * b1(0) + (series[0] - b2(0));
    const double odd = (two_y - 1.0) * b1(1) + (series[1] - b2(1));  // over T_1 = T_-1 = x
    return even + x * odd;
  }

  double arc(const Cubic& cubic, double from, double to) const {
    double sum = 0.0;
    for (long k = 0; k < rule_.node.size(); ++k) {
      sum += rule_.weight(k) * cubic.speed(from + (to - from) * rule_.node(k));
    }
    return (to - from) * sum;
  }

  /// t - from where the arc length from `from` is `wanted`, by Newton.
  double parameter(const Cubic& cubic, double from, double span, double wanted, double total) const {
    double t = span * wanted / total;
    for (int iteration = 0; iteration < 20; ++iteration) {
      const double step = (arc(cubic, from, from + t) - wanted) / cubic.speed(from + t);
      t = std::clamp(t - step, 0.0, span);
      if (std::abs(step) < 1e-16 * scale_) break;
    }
    return t;
  }

  Series inverse_series(const Cubic& cubic, double from, double span, double total) const {
    std::array<double, terms> value{};
    for (std::size_t j = 0; j < terms; ++j) {
      const double x = std::cos(std::numbers::pi * (static_cast<double>(j) + 0.5) / terms);
      value[j] = parameter(cubic, from, span, 0.5 * (1.0 + x) * total, total);
    }
    Series series{};
    for (std::size_t k = 0; k < terms; ++k) {
      double sum = 0.0;
      for (std::size_t j = 0; j < terms; ++j) {
        sum += value[j] *
               std::cos(std::numbers::pi * static_cast<double>(k) * (static_cast<double>(j) + 0.5) / terms);
      }
      series[k] = (k == 0 ? 1.0 : 2.0) / terms * sum;
    }
    return series;
  }

  void add_pieces(std::size_t index, double from, double span, int depth) {
    const Cubic& cubic = cubics_[index];
    const double half = 0.5 * span;
    const double tolerance = 2e-15 * scale_;
    const double total = arc(cubic, from, from + span);
    const double halves = arc(cubic, from, from + half) + arc(cubic, from + half, from + span);
    bool sound = std::abs(total - halves) < tolerance;
    Piece piece{length_, total, from, index, {}};
    if (sound) {
      piece.inverse = inverse_series(cubic, from, span, total);
      for (const double x : {-1.0, -0.93, -0.41, 0.13, 0.58, 0.97, 1.0}) {
        const double t = chebyshev(piece.inverse, x);
        sound = sound && std::abs(arc(cubic, from, from + t) - 0.5 * (1.0 + x) * total) < tolerance;
      }
    }
    if (sound) {
      pieces_.push_back(piece);
      length_ += total;
      return;
    }
    if (depth == 12) {
      throw Error(
          fmt::format("spline_through: the curve must not turn back on itself, but it has a cusp near {}; "
                      "check the order of the points",
                      text(cubic.position(from + half))));
    }
    add_pieces(index, from, half, depth + 1);
    add_pieces(index, from + half, half, depth + 1);
  }

  std::vector<Cubic> cubics_;
  GaussRule rule_;
  std::vector<Piece> pieces_;
  double length_ = 0.0;
  double scale_ = 0.0;  ///< sum of chords: the length that rounding is measured against
};

void check(const Points& points, double length) {
  if (points.size() < 2) {
    throw Error(fmt::format("spline_through: at least 2 points, got {}", points.size()));
  }
  double scale = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      throw Error(
          fmt::format("spline_through: coordinates must be finite, point {} is {}", i + 1, text(points[i])));
    }
    if (i > 0) scale += (points[i] - points[i - 1]).norm();
  }
  for (std::size_t i = 1; i < points.size(); ++i) {
    // The negation also catches a scale of zero.
    if (!((points[i] - points[i - 1]).norm() > 1e-9 * scale)) {
      throw Error(
          fmt::format("spline_through: neighbouring points must differ, points {} and {} coincide at {}", i,
                      i + 1, text(points[i])));
    }
  }
  if (!(length >= 0.0 && std::isfinite(length))) {
    throw Error(fmt::format("spline_through: length must be positive, got {:g} m", length));
  }
}

/// All on the line from the first to the last, in order.
bool straight_in_order(const Points& points) {
  const Vector3d chord = points.back() - points.front();
  const double length = chord.norm();
  double reached = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Vector3d offset = points[i] - points.front();
    const double along = offset.dot(chord) / length;
    if (!(along > reached) || (offset - along / length * chord).norm() > 1e-12 * length) return false;
    reached = along;
  }
  return true;
}

std::shared_ptr<const Centreline::Curve> curve_through(const Points& points) {
  if (straight_in_order(points)) return std::make_shared<Line>(points.front(), points.back());
  return std::make_shared<Spline>(points);
}

class Scaled final : public Centreline::Curve {
 public:
  Scaled(std::shared_ptr<const Centreline::Curve> curve, double factor)
      : curve_(std::move(curve)), factor_(factor), origin_(curve_->at(0.0).position) {}
  double length() const override { return factor_ * curve_->length(); }
  CurvePoint at(double s) const override {
    const CurvePoint point = curve_->at(std::min(s / factor_, curve_->length()));
    return {origin_ + factor_ * (point.position - origin_), point.tangent, point.curvature / factor_};
  }
  bool is_straight() const override { return curve_->is_straight(); }

 private:
  std::shared_ptr<const Centreline::Curve> curve_;
  double factor_;
  Vector3d origin_;
};

}  // namespace

Centreline Centreline::scaled(double factor) const {
  if (!(factor > 0.0 && std::isfinite(factor)))
    throw Error(fmt::format("Centreline::scaled: the factor must be positive, got {:g}", factor));
  return Centreline(std::make_shared<Scaled>(curve_, factor));
}

double Centreline::length() const {
  return curve_->length();
}

CurvePoint Centreline::at(double s) const {
  const double length = curve_->length();
  const double slack = 1e-12 * length;
  if (!(s >= -slack && s <= length + slack)) {
    throw Error(fmt::format("Centreline::at: arc length must lie in [0, {:.9g}] m, got {:.9g} m", length, s));
  }
  return curve_->at(std::clamp(s, 0.0, length));
}

bool Centreline::is_straight() const {
  return curve_->is_straight();
}

Centreline straight_line(const Vector3d& from, const Vector3d& to) {
  if (!from.allFinite() || !to.allFinite() || !((to - from).norm() > 0.0)) {
    throw Error(fmt::format("straight_line: the ends must be finite and differ, got {} and {}", text(from),
                            text(to)));
  }
  return Centreline(std::make_shared<Line>(from, to));
}

Centreline circular_arc(double length, double angle) {
  if (!(length > 0.0 && std::isfinite(length))) {
    throw Error(fmt::format("circular_arc: length must be positive, got {:g} m", length));
  }
  if (!(angle > 0.0 && angle < 2.0 * std::numbers::pi)) {
    throw Error(fmt::format("circular_arc: angle must lie between 0 and 2 pi, got {:g} rad", angle));
  }
  return Centreline(std::make_shared<Arc>(length, angle));
}

Centreline spline_through(const std::vector<Vector3d>& points, double length) {
  check(points, length);
  if (length == 0.0) return Centreline(curve_through(points));
  // Arc length scales with the points, so one raw measurement gives the factor.
  const double factor = length / curve_through(points)->length();
  Points scaled = points;
  for (Vector3d& point : scaled) point = points.front() + factor * (point - points.front());
  return Centreline(curve_through(scaled));
}

}  // namespace struna::fem
