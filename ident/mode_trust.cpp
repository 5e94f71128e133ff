#include "ident/mode_trust.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/mode_flags.hpp"

namespace struna::ident {
namespace {

constexpr double unknown_modulus_sigma = 5e-3;  // relative, where the modes have no standard errors
constexpr double unknown_loss_factor_sigma = 5e-2;
constexpr double worst_modulus_sigma = 0.02;  // relative; a mode known worse than this says nothing
constexpr double worst_loss_factor_sigma = 0.10;
constexpr double poor_circle_sigma =
    0.03;  // relative, of a loss factor from a multi-mode fit whose circle is poor
constexpr double separate_enough = 0.5;  // bandwidths between neighbours whose loss factors can be told apart
constexpr double felt = 2.0;             // bandwidths within which a mode too weak to be found leaves a trace
constexpr double one_resonance =
    0.05;  // bandwidths between two modes that widen their common pole too little to matter
constexpr double close_frequency_error =
    0.05;  // bandwidths, of a frequency read off a circle shared with a neighbour

}  // namespace

double neighbour_distance(const std::vector<Mode>& modes, std::size_t mine) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < modes.size(); ++j) {
    if (j == mine) continue;
    const double distance = std::abs(modes[j].natural_frequency_hz - modes[mine].natural_frequency_hz);
    nearest = std::min(nearest, distance);
  }
  return nearest / (modes[mine].loss_factor * modes[mine].natural_frequency_hz);
}

double missing_distance(const Pairing& pairing, const ModelModes& model, const Pair& pair,
                        double loss_factor) {
  double nearest = std::numeric_limits<double>::infinity();
  const double mine = model.eigenvalue[pair.model.front()];
  for (const int missing : pairing.missing)
    nearest = std::min(nearest, std::abs(std::sqrt(model.eigenvalue[missing] / mine) - 1.0));
  return nearest / loss_factor;
}

std::optional<std::string> distrust_both(const Mode& mode) {
  if (mode.has(ModeFlag::not_converged)) return "not_converged: its fit did not settle";
  if (mode.has(ModeFlag::edge)) return "edge: its half-power band reaches past the band analysed";
  return std::nullopt;
}

std::optional<std::string> distrust_modulus(double relative_sigma) {
  if (relative_sigma > worst_modulus_sigma) {
    return fmt::format("modulus: known to {:.1f} % only, more than {:.0f} %", 100.0 * relative_sigma,
                       100.0 * worst_modulus_sigma);
  }
  return std::nullopt;
}

std::optional<std::string> distrust_loss_factor(const Pair& pair, const Mode& mode,
                                                const Surroundings& around) {
  if (!(mode.loss_factor > 0.0) || !std::isfinite(mode.loss_factor)) {
    return fmt::format("loss factor: must be positive, got {}", mode.loss_factor);
  }
  if (mode.has(ModeFlag::coarse)) return "loss factor: coarse: too few lines in the half-power band";
  if (mode.has(ModeFlag::poor_circle) && !is_refined(mode)) {
    return "loss factor: poor_circle: not the circle of one mode";
  }
  if (around.spread > one_resonance) {
    return fmt::format("loss factor: one pole for two modes {:.2f} bandwidths apart", around.spread);
  }
  const bool explained = around.missing > separate_enough && around.missing < felt;
  if (mode.has(ModeFlag::double_mode) && pair.model.size() < 2 && !explained) {
    return "loss factor: double_mode: one pole for two modes that the model does not have";
  }
  if (mode.has(ModeFlag::close_modes) && !is_refined(mode))
    return "loss factor: close_modes: the circle is not this mode's own";
  if (is_refined(mode) && around.neighbour < separate_enough && !around.several_references)
    return fmt::format("loss factor: close_modes: a neighbour {:.2f} bandwidths away", around.neighbour);
  if (mode.loss_factor_sigma > worst_loss_factor_sigma * mode.loss_factor) {
    return fmt::format("loss factor: noisy: known to {:.0f} % only, more than {:.0f} %",
                       100.0 * mode.loss_factor_sigma / mode.loss_factor, 100.0 * worst_loss_factor_sigma);
  }
  return std::nullopt;
}

double relative_modulus_sigma(const Pair& pair, const Mode& mode, double floor) {
  double sigma = pair.modulus_sigma / pair.modulus;
  if (!std::isfinite(mode.natural_frequency_sigma)) sigma = std::hypot(sigma, unknown_modulus_sigma);
  if (mode.has(ModeFlag::close_modes) && !is_refined(mode)) {
    sigma = std::hypot(sigma, 2.0 * close_frequency_error * mode.loss_factor);
  }
  return std::hypot(sigma, floor);
}

double relative_loss_factor_sigma(const Mode& mode, double floor) {
  const double given = mode.loss_factor_sigma / mode.loss_factor;
  const double relative = std::isfinite(given) ? given : unknown_loss_factor_sigma;
  const double doubt = mode.has(ModeFlag::poor_circle) ? poor_circle_sigma : 0.0;
  return std::hypot(relative, doubt, floor);
}

}  // namespace struna::ident
