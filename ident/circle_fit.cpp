#include "ident/circle_fit.hpp"

#include <ceres/tiny_solver.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "ident/mode_flags.hpp"
#include "ident/noise_floor.hpp"
#include "ident/pole_fit.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;
constexpr int most_iterations = 30;  // a circle with its angles settles in ten

// Distances from a circle (centre x, y, radius), weighted, for Ceres' small-problem solver.
struct GeometricMisfit {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 3 };
  const Eigen::VectorXcd& z;
  Eigen::VectorXd root_weight;

  int NumResiduals() const { return static_cast<int>(z.size()); }
  bool operator()(const double* p, double* residuals, double* jacobian) const {
    const long n = z.size();
    for (long i = 0; i < n; ++i) {
      const Complex radial = z(i) - Complex(p[0], p[1]);
      const double distance = std::max(std::abs(radial), 1e-300);
      residuals[i] = root_weight(i) * (distance - p[2]);
      if (jacobian == nullptr) continue;
      jacobian[i] = -root_weight(i) * radial.real() / distance;
      jacobian[n + i] = -root_weight(i) * radial.imag() / distance;
      jacobian[2 * n + i] = -root_weight(i);
    }
    return true;
  }
};

// The fastest turning line: where the angle law is centred.
long fastest_line(const Eigen::VectorXcd& z) {
  long fastest = z.size() / 2;
  double largest = 0.0;
  for (long i = 1; i + 1 < z.size(); ++i) {
    const double turn = std::abs(z(i + 1) - z(i - 1));
    if (turn > largest) {
      largest = turn;
      fastest = i;
    }
  }
  return fastest;
}

struct OutputCircle {
  PlaneCircle plane;
  double misfit = 0.0;   // weighted, about the geometric circle
  double scatter = 0.0;  // rms distance over radius
};

OutputCircle fit_plane_circle(const TransferFunction::Output& output) {
  const Eigen::VectorXd weight = output.sigma.cwiseAbs2().cwiseInverse();
  OutputCircle circle;
  circle.plane = geometric_circle(output.value, weight, taubin_circle(output.value, weight));
  circle.misfit = circle_misfit(output.value, weight, circle.plane);
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(output.value.size());
  circle.scatter =
      std::sqrt(circle_misfit(output.value, equal, circle.plane) / static_cast<double>(output.value.size())) /
      circle.plane.radius;
  return circle;
}

// A pole from the angle laws of all outputs, weighted by (radius/sigma)^2; false where they give none in the
// window.
bool pole_from_angles(const TransferFunction& window, const std::vector<OutputCircle>& circles,
                      fem::Damping damping, Pole& pole) {
  const bool structural = damping == fem::Damping::structural;
  const Eigen::VectorXd s =
      structural ? Eigen::VectorXd(window.frequency_hz.cwiseAbs2()) : window.frequency_hz;
  Complex sum = 0.0;
  double weights = 0.0;
  for (std::size_t k = 0; k < circles.size(); ++k) {
    const auto& output = window.outputs[k];
    const Eigen::VectorXd weight = output.sigma.cwiseAbs2().cwiseInverse();
    const Complex root = angle_law_root(output.value, weight, s, circles[k].plane);
    const double share = weight.mean() * circles[k].plane.radius * circles[k].plane.radius;
    if (!std::isfinite(root.real()) || !std::isfinite(root.imag()) || !std::isfinite(share)) continue;
    if (root.real() < s(0) || root.real() > s(s.size() - 1)) continue;
    sum += share * Complex(root.real(), std::abs(root.imag()));
    weights += share;
  }
  if (!(weights > 0.0)) return false;
  const Complex root = sum / weights;
  pole.natural_frequency_hz = structural ? std::sqrt(root.real()) : std::abs(root);
  pole.loss_factor = structural ? root.imag() / root.real() : 2.0 * root.imag() / std::abs(root);
  return pole.loss_factor > 1e-6 && pole.loss_factor < 1.0;
}

Circle to_circle(const PoleFit& fit, long k, const TransferFunction& window, fem::Damping damping,
                 double scatter) {
  const Pole& pole = fit.poles.front();
  const auto share = [&](double f_hz) {
    return fit.constant(0, k) * pole_function(pole, 2.0 * std::numbers::pi * f_hz, damping);
  };
  long nearest = 0;
  (window.frequency_hz.array() - pole.natural_frequency_hz).abs().minCoeff(&nearest);
  const Complex offset = fit.fitted(nearest, k) - share(window.frequency_hz(nearest));
  const double top_hz = damping == fem::Damping::structural
                            ? pole.natural_frequency_hz
                            : viscous_root(pole).imag() / (2.0 * std::numbers::pi);
  Circle circle;
  circle.centre = offset + 0.5 * share(top_hz);
  circle.radius = 0.5 * std::abs(share(top_hz));
  circle.at_resonance = offset + share(pole.natural_frequency_hz);
  circle.at_lower_half_power = offset + share(lower_half_power_hz(pole, damping));
  circle.at_upper_half_power = offset + share(upper_half_power_hz(pole, damping));
  circle.scatter = scatter;
  return circle;
}

// Weighted mean square distance per degree of freedom, over all outputs, and the same unweighted over the
// radius.
bool is_poor(const std::vector<OutputCircle>& circles, long lines) {
  double misfit = 0.0, scatter = 1.0;
  for (const auto& circle : circles) {
    misfit += circle.misfit;
    scatter = std::min(scatter, circle.scatter);
  }
  const double freedom = static_cast<double>(circles.size()) * static_cast<double>(lines - 3);
  return freedom > 0.0 && misfit > poor_circle_misfit * poor_circle_misfit * freedom &&
         scatter > poor_circle_scatter;
}

}  // namespace

PlaneCircle taubin_circle(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight) {
  if (z.size() < 3 || weight.size() != z.size())
    throw Error(fmt::format("taubin_circle: at least 3 points with a weight each, got {} and {}", z.size(),
                            weight.size()));
  const double total = weight.sum();
  const Complex mean = z.cwiseProduct(weight.cast<Complex>()).sum() / total;
  const Eigen::ArrayXcd centred = z.array() - mean;
  const double size = std::sqrt((weight.array() * centred.abs2()).sum() / total);
  if (!(size > 0.0)) return {mean, 0.0};
  // Moments of (x, y, x^2 + y^2 - mean) with unit size: Taubin's problem is an eigenvalue problem in them.
  const Eigen::ArrayXd x = centred.real() / size, y = centred.imag() / size;
  Eigen::MatrixX3d rows(z.size(), 3);
  rows.col(0) = 0.5 * (x.square() + y.square() - 1.0);
  rows.col(1) = x;
  rows.col(2) = y;
  const Eigen::Matrix3d moments = rows.transpose() * (weight / total).asDiagonal() * rows;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moments);
  const Eigen::Vector3d direction = eigen.eigenvectors().col(0);
  const double a = direction(0);
  if (std::abs(a) < 1e-12)
    return {mean + size * 1e12, size * 1e12};  // a straight line: a circle of no curvature
  const Complex centre(-direction(1) / a, -direction(2) / a);
  return {mean + size * centre, size * std::sqrt(std::norm(centre) + 1.0)};
}

PlaneCircle geometric_circle(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight,
                             const PlaneCircle& start) {
  // In units of the start circle, so that the solver's absolute tolerances mean something.
  const double unit = start.radius > 0.0 ? start.radius : 1.0;
  const Eigen::VectorXcd scaled = (z.array() - start.centre) / unit;
  const GeometricMisfit misfit{scaled, (weight / weight.mean()).cwiseSqrt()};
  ceres::TinySolver<GeometricMisfit> solver;
  solver.options.gradient_tolerance = 1e-14;
  solver.options.parameter_tolerance = 1e-12;
  Eigen::Vector3d p(0.0, 0.0, start.radius / unit);
  solver.Solve(misfit, &p);
  const PlaneCircle circle{start.centre + unit * Complex(p(0), p(1)), unit * std::abs(p(2))};
  return circle_misfit(z, weight, circle) <= circle_misfit(z, weight, start) ? circle : start;
}

double circle_misfit(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight, const PlaneCircle& circle) {
  return (weight.array() * ((z.array() - circle.centre).abs() - circle.radius).square()).sum();
}

Complex angle_law_root(const Eigen::VectorXcd& z, const Eigen::VectorXd& weight, const Eigen::VectorXd& s,
                       const PlaneCircle& circle) {
  const long n = z.size(), middle = fastest_line(z);
  const Complex reference = z(middle) - circle.centre;
  const double unit = 0.5 * (s(n - 1) - s(0));
  const Eigen::ArrayXd t = (s.array() - s(middle)) / unit;
  Eigen::ArrayXd half_angle(n);
  for (long i = 0; i < n; ++i) half_angle(i) = 0.5 * std::arg((z(i) - circle.centre) / reference);
  const Eigen::ArrayXd sine = half_angle.sin(), cosine = half_angle.cos();
  Eigen::Vector3d pqr(0.0, -1.0, 0.0);
  for (int pass = 0; pass < 4; ++pass) {
    // An error of the angle moves the equation by half of |1 + r t + i (p + q t)|.
    const Eigen::ArrayXd slope_square = (1.0 + pqr(2) * t).square() + (pqr(0) + pqr(1) * t).square();
    Eigen::VectorXd w = weight;
    if (pass > 0) w.array() /= slope_square.max(1e-12);
    Eigen::MatrixX3d rows(n, 3);
    rows.col(0) = cosine;
    rows.col(1) = cosine * t;
    rows.col(2) = -sine * t;
    const Eigen::Matrix3d normal = rows.transpose() * w.asDiagonal() * rows;
    pqr = normal.ldlt().solve(rows.transpose() * w.cwiseProduct(sine.matrix()));
  }
  const Complex root = -Complex(1.0, pqr(0)) / Complex(pqr(2), pqr(1));
  return s(middle) + unit * root;
}

Mode fit_circle(const TransferFunction& circle_form_tf, double start_hz, double lo_hz, double hi_hz,
                const CircleFitOptions& options) {
  const bool sigma_known = options.sigma_known && has_sigma(circle_form_tf);
  const long in_window =
      ((circle_form_tf.frequency_hz.array() >= lo_hz) && (circle_form_tf.frequency_hz.array() <= hi_hz))
          .count();
  if (in_window < 4)
    throw Error(fmt::format(
        "fit_circle: at least 4 lines in {} to {} Hz, got {}; widen the window or refine the lines", lo_hz,
        hi_hz, in_window));
  const TransferFunction window = restrict_band(
      has_sigma(circle_form_tf) ? circle_form_tf : with_noise_floor(circle_form_tf), lo_hz, hi_hz);

  std::vector<OutputCircle> circles;
  for (const auto& output : window.outputs) circles.push_back(fit_plane_circle(output));
  Pole start{start_hz, std::min(1.0, 0.5 * (hi_hz - lo_hz) / start_hz)};
  Pole from_angles;
  if (pole_from_angles(window, circles, options.damping, from_angles)) start = from_angles;

  PoleFitOptions fit_options;
  fit_options.damping = options.damping;
  fit_options.residual = options.linear_residual ? ResidualTerms::linear : ResidualTerms::constant;
  fit_options.conjugate_term = false;
  fit_options.sigma_known = sigma_known;
  fit_options.max_iterations = most_iterations;
  const PoleFit fit = fit_poles(window, {start}, fit_options);

  Mode mode = to_mode(fit, 0, options.damping);
  mode.circle_natural_frequency_hz = mode.natural_frequency_hz;
  mode.circle_loss_factor = mode.loss_factor;
  mode.window_lo_hz = window.frequency_hz(0);
  mode.window_hi_hz = window.frequency_hz(window.lines() - 1);
  for (std::size_t k = 0; k < circles.size(); ++k)
    mode.circles.push_back(to_circle(fit, static_cast<long>(k), window, options.damping, circles[k].scatter));
  if (is_poor(circles, window.lines())) add_flag(mode, ModeFlag::poor_circle);
  return mode;
}

}  // namespace struna::ident
