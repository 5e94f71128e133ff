#include "ident/second_pole.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace struna::ident {
namespace {

constexpr long least_lines = 8;
constexpr double most_correlation = 2.5;  // lines worth one, as windows and local models leave them
constexpr double one_in_2000 = 3.29, one_in_20 = 1.645;  // deviations of a normal variable
// Smaller parts of the share are the model's own error.
constexpr double least_part_of_one = 0.005, least_part_of_several = 0.0035;
constexpr double normal_95 = 1.645;
// |C1 - C2|/|C1 + C2| of heights 60 degrees apart: modal assurance 1/4.
constexpr double half_angle = 0.57735;
// What a test looks for: a part of the residual beside that of one pole.
struct Test {
  double freedom = 0.0;
  double gain = 0.0;   // of the residual
  double first = 0.0;  // expected of a pair s bandwidths apart: first s^2 + second s^4
  double second = 0.0;

  bool beyond(double deviation, double scale, double least_gain) const {
    return freedom > 0.0 && gain > std::max(scale * chi_square_quantile(freedom, deviation), least_gain);
  }
  double resolves_from(double deviation, double scale, double least_gain) const {
    if (!(freedom > 0.0)) return std::numeric_limits<double>::infinity();
    const double threshold = std::max(chi_square_quantile(freedom, deviation), least_gain / scale);
    const double asked = scale * noticed_noncentrality(threshold, freedom);
    // Root of second x^2 + first x = asked in the form that neither loses digits nor divides by nothing.
    return std::sqrt(2.0 * asked / (first + std::sqrt(first * first + 4.0 * second * asked)));
  }
};

// Phase of a frequency's change, which goes with g^2: of dg/df over g^2 at the peak.
std::complex<double> phase_of_shift(const Eigen::VectorXcd& g) {
  long peak = 0;
  g.cwiseAbs().maxCoeff(&peak);
  const long m = std::clamp(peak, 1L, g.size() - 2);
  const std::complex<double> shift = (g(m + 1) - g(m - 1)) / (g(m) * g(m));
  return shift / std::abs(shift);
}

// The same sign or the opposite in every output, as far as the modes are real.
std::complex<double> common_phase(const Eigen::VectorXcd& height, const Eigen::MatrixXd& sigma) {
  std::complex<double> sum = 0.0;
  for (long k = 0; k < height.size(); ++k) sum += height(k) * height(k) / sigma.col(k).squaredNorm();
  return std::abs(sum) > 0.0 ? std::sqrt(sum / std::abs(sum)) : 1.0;  // (1, i): any phase is as good
}

// What one pole may leave, the pole, and what a second one adds.
Eigen::MatrixXcd shapes_of(const Eigen::VectorXcd& g) {
  Eigen::MatrixXcd shapes(g.size(), 5);
  shapes.col(0).setOnes();
  shapes.col(1).setLinSpaced(g.size(), -1.0, 1.0);
  for (int power = 1; power <= 3; ++power) shapes.col(power + 1) = g.array().pow(power);
  return shapes;
}

}  // namespace

double chi_square_quantile(double freedom, double deviation) {
  const double part = 2.0 / (9.0 * freedom);
  return freedom * std::pow(1.0 - part + deviation * std::sqrt(part), 3.0);
}

double noticed_noncentrality(double threshold, double freedom) {
  return std::pow(std::sqrt(threshold) + normal_95, 2.0) - (freedom - 1.0);
}

LinesOfPole lines_of_pole(const PoleFit& fit, long r, const TransferFunction& window, long first, long last,
                          fem::Damping damping) {
  const Pole& pole = fit.poles[static_cast<std::size_t>(r)];
  const double scale = pole_scale(pole, damping);
  const long lines = last - first;
  LinesOfPole of;
  of.g.resize(lines);
  for (long i = 0; i < lines; ++i)
    of.g(i) = pole_function(pole, 2.0 * std::numbers::pi * window.frequency_hz(first + i), damping);
  of.g *= scale;
  of.height = fit.constant.row(r).transpose() / scale;
  of.sigma.resize(lines, of.height.size());
  for (long k = 0; k < of.height.size(); ++k)
    of.sigma.col(k) = window.outputs[static_cast<std::size_t>(k)].sigma.segment(first, lines);
  of.residual = fit.residual.middleRows(first, lines);
  of.line_correlation = fit.line_correlation;
  return of;
}

Eigen::MatrixXcd alone(const LinesOfPole& lines) {
  Eigen::MatrixXcd values(lines.g.size(), lines.height.size());
  for (long k = 0; k < values.cols(); ++k)
    values.col(k) = (lines.height(k) * lines.g + lines.residual.col(k).cwiseProduct(lines.sigma.col(k))) /
                    lines.sigma.col(k).mean();
  return values;
}

SecondPole second_pole(const LinesOfPole& lines) {
  const long n = lines.g.size(), outputs = lines.height.size();
  if (n < least_lines) return {};
  const Eigen::MatrixXcd shapes = shapes_of(lines.g);
  const long columns = shapes.cols(), square = columns - 2, cube = columns - 1;
  Test of_both, of_square, in_phase;
  const std::complex<double> phase =
      std::conj(common_phase(lines.height, lines.sigma) * phase_of_shift(lines.g));
  double rest = 0.0, own = 0.0, seen = 0.0, along = 0.0, across = 0.0;
  for (long k = 0; k < outputs; ++k) {
    const Eigen::VectorXd weight = lines.sigma.col(k).cwiseInverse();
    // Each column beside those before it: what it gains, and what it could.
    const Eigen::HouseholderQR<Eigen::MatrixXcd> qr(weight.asDiagonal() * shapes);
    const Eigen::VectorXcd part = qr.householderQ().adjoint() * lines.residual.col(k);
    const double of_g2 = std::norm(qr.matrixQR()(square, square));
    const double of_g3 = std::norm(qr.matrixQR()(cube, cube));
    const double height = std::norm(lines.height(k));
    of_square.gain += std::norm(part(square));
    // The column's own direction: R's diagonal has its sign.
    in_phase.gain +=
        std::pow((part(square) * std::conj(qr.matrixQR()(square, square)) * phase).real(), 2.0) / of_g2;
    of_both.gain += std::norm(part(square)) + std::norm(part(cube));
    rest += part.tail(n - columns).squaredNorm();
    own += height * (weight.asDiagonal() * lines.g).squaredNorm();
    seen += of_g2;
    along += height * of_g2;
    across += height * of_g2 * of_g2;
    of_both.second += height * of_g3;
  }
  // The difference's share in each output, without its part along the pole's own.
  const double mean = lines.height.squaredNorm() / static_cast<double>(outputs);
  of_both.first = of_square.first = in_phase.first =
      half_angle * half_angle * mean * std::max(0.0, along > 0.0 ? seen - across / along : 0.0);
  of_both.freedom = static_cast<double>(4 * outputs - 2);
  of_square.freedom = static_cast<double>(2 * outputs - 2);
  in_phase.freedom = static_cast<double>(outputs - 1);
  // What no second pole explains: its own trace in the residual must not pass for noise.
  const double unexplained = rest / static_cast<double>(2 * outputs * (n - columns));
  const double scale = std::max(1.0, unexplained) * std::min(lines.line_correlation, most_correlation);
  const double least_part = outputs == 1 ? least_part_of_one : least_part_of_several;
  const double least_gain = least_part * least_part * own;
  const Test& hint = outputs > 1 ? in_phase : of_both;
  SecondPole result;
  result.hinted = hint.beyond(one_in_20, scale, least_gain);
  result.resolves_from = hint.resolves_from(one_in_20, scale, least_gain);
  for (const Test& test : {of_both, of_square, in_phase}) {
    result.noticed = result.noticed || test.beyond(one_in_2000, scale, least_gain);
    result.resolves_from = std::min(result.resolves_from, test.resolves_from(one_in_2000, scale, least_gain));
  }
  return result;
}

}  // namespace struna::ident
