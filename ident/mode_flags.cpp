#include "ident/mode_flags.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "ident/leakage.hpp"

namespace struna::ident {
namespace {

// Of a function that does not leak: a resonance of fewer line spacings, and known worse than this, is coarse.
constexpr double between_lines = 0.6;
constexpr double between_lines_noise = 0.003;

double half_power_band(const Mode& mode) {
  return mode.upper_half_power_hz - mode.lower_half_power_hz;
}

// Square of what no combination of the columns explains.
double remainder(const Eigen::MatrixXcd& columns, const Eigen::VectorXcd& vector) {
  const Eigen::VectorXcd c = (columns.adjoint() * columns).ldlt().solve(columns.adjoint() * vector);
  return (vector - columns * c).squaredNorm();
}

}  // namespace

bool is_refined(const Mode& mode) {
  return std::isfinite(mode.loss_factor_sigma) &&
         mode.circle_natural_frequency_hz != mode.natural_frequency_hz;
}

bool is_coarse(const Mode& mode, double line_spacing_hz, double leakage_hz) {
  if (std::isnan(leakage_hz)) return half_power_band(mode) < coarse_lines * line_spacing_hz;
  if (leakage_hz == 0.0)  // its standard error falls short there
    return half_power_band(mode) < between_lines * line_spacing_hz &&
           !(mode.loss_factor_sigma <= between_lines_noise * mode.loss_factor);
  const double doubt = leakage_doubt * leakage_widening(half_power_band(mode), leakage_hz);
  return doubt > coarse_doubt && !(doubt * mode.loss_factor < mode.loss_factor_sigma);
}

bool is_noisy(const Mode& mode) {
  return mode.natural_frequency_sigma > noisy_frequency * half_power_band(mode) ||
         mode.loss_factor_sigma > noisy_loss_factor * mode.loss_factor;
}

bool reaches_edge(const Mode& mode, double band_lo_hz, double band_hi_hz) {
  return mode.lower_half_power_hz < band_lo_hz || mode.upper_half_power_hz > band_hi_hz;
}

bool are_close(const Mode& mode, const Mode& other) {
  const double distance = std::abs(mode.natural_frequency_hz - other.natural_frequency_hz);
  if (is_refined(mode))
    return distance < 5.0 * std::hypot(mode.natural_frequency_sigma, other.natural_frequency_sigma);
  return distance < std::max(half_power_band(mode), half_power_band(other));
}

bool looks_double(const Eigen::MatrixXcd& alone, const Eigen::VectorXcd& g) {
  const long lines = alone.rows(), outputs = alone.cols();
  if (outputs < 2 || lines < 6) return false;
  const Eigen::MatrixXcd gram = alone.adjoint() * alone;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> eigen(gram);
  const double first = std::sqrt(std::max(0.0, eigen.eigenvalues()(outputs - 1)));
  const double second = std::sqrt(std::max(0.0, eigen.eigenvalues()(outputs - 2)));
  const double noise =
      std::sqrt(2.0) * (std::sqrt(static_cast<double>(lines)) + std::sqrt(static_cast<double>(outputs - 1)));
  if (second <= double_mode_noise * noise || second <= double_mode_share * first) return false;
  const Eigen::VectorXcd vector = alone * eigen.eigenvectors().col(outputs - 2);
  const Eigen::VectorXcd unit = g / g.cwiseAbs().maxCoeff();
  Eigen::MatrixXcd shapes(lines, 3);
  shapes << Eigen::VectorXcd::Ones(lines), unit, unit.cwiseProduct(unit);
  const double without = remainder(shapes.leftCols(2), vector), with = remainder(shapes, vector);
  return without - with > double_mode_shape * vector.squaredNorm();
}

bool may_be_two(const Mode& mode) {
  return mode.resolves_from > unseen_pair && !mode.has(ModeFlag::double_mode);
}

void add_flag(Mode& mode, ModeFlag flag) {
  if (!mode.has(flag)) mode.flags.push_back(flag);
}

void flag_modes(std::vector<Mode>& modes, double line_spacing_hz, double leakage_hz, double band_lo_hz,
                double band_hi_hz) {
  for (std::size_t r = 0; r < modes.size(); ++r) {
    Mode& mode = modes[r];
    if (is_coarse(mode, line_spacing_hz, leakage_hz)) add_flag(mode, ModeFlag::coarse);
    if (is_noisy(mode)) add_flag(mode, ModeFlag::noisy);
    if (reaches_edge(mode, band_lo_hz, band_hi_hz)) add_flag(mode, ModeFlag::edge);
    if (may_be_two(mode)) add_flag(mode, ModeFlag::may_be_two);
    for (std::size_t s = 0; s < modes.size(); ++s)
      if (s != r && are_close(mode, modes[s])) add_flag(mode, ModeFlag::close_modes);
  }
}

}  // namespace struna::ident
