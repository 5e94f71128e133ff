#include "ident/pairing_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "fem/error.hpp"
#include "ident/assignment.hpp"
#include "ident/modal_assurance.hpp"
#include "ident/references.hpp"

namespace struna::ident {
namespace {

// Prices, in the unit of -ln likelihood, roughly: a sound pair costs below 1.
constexpr double price_alone_sound = 3.0;
constexpr double price_alone_doubtful = 1.5;
constexpr double price_missing_visible = 2.0;
constexpr double price_reversed = 2.0;  // once, for all signs reversed
constexpr double shape_weight = 4.0;    // of 1 - correlation of the constants …
constexpr double shape_limit = 3.0;     // … which cannot cost more than this
constexpr double amplitude_weight =
    0.25;  // of the squared logarithm of the amplitude ratio: calibration is often off
constexpr double amplitude_limit = 1.0;
constexpr double slope_weight =
    0.5;                       // of ((n - n_KK)/0.1)^2: weak, against aliases that a steep law would fit
constexpr double reach = 6.0;  // tolerances beyond which nothing is paired

// Nearly double modes, in half-power bandwidths: closer ones no measurement parts; up to the other, one pole
// may stand for both.
constexpr double inseparable = 0.05;
constexpr double inseparable_by_references = 0.001;  // constants of rank one part all but equal ones
constexpr double confusable = 0.3;
constexpr double usual_loss_factor = 0.02;  // where the modes tell none

double median(std::vector<double> v) {
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// The constant as that of a real mode's C/(omega_r^2(1 + i eta) - omega^2). A viscous one is a residue at
/// the pole: C/(2 i omega_r) of that for apparent mass, and C/2 for mobility (to first order in zeta).
Eigen::VectorXcd structural_constant(const Mode& mode, const ModeSet& set) {
  if (set.damping == fem::Damping::structural) return mode.modal_constant;
  if (set.form == FrfKind::mobility) return 2.0 * mode.modal_constant;
  const std::complex<double> factor(0.0, 4.0 * std::numbers::pi * mode.natural_frequency_hz);
  return factor * mode.modal_constant;
}

Candidate candidate_of(const Mode& mode, const ModeSet& set) {
  Candidate c;
  if (!(mode.natural_frequency_hz > 0.0) || !std::isfinite(mode.natural_frequency_hz)) {
    throw Error(fmt::format("pair_modes: natural frequencies must be positive, got {} Hz",
                            mode.natural_frequency_hz));
  }
  c.ln_f = std::log(mode.natural_frequency_hz);
  if (std::isfinite(mode.natural_frequency_sigma))
    c.ln_f_sigma = std::abs(mode.natural_frequency_sigma) / mode.natural_frequency_hz;
  if (std::isfinite(mode.loss_factor)) c.loss_factor = std::max(0.0, mode.loss_factor);
  if (mode.modal_constant.size() > 0 && mode.modal_constant.allFinite() && mode.modal_constant.norm() > 0.0) {
    c.constant = structural_constant(mode, set);
    const bool known = mode.modal_constant_sigma.size() == mode.modal_constant.size() &&
                       mode.modal_constant_sigma.allFinite();
    if (known) c.noise = 2.0 * mode.modal_constant_sigma.squaredNorm() / mode.modal_constant.squaredNorm();
  }
  const bool doubtful = mode.has(ModeFlag::noisy) || mode.has(ModeFlag::poor_circle) ||
                        mode.has(ModeFlag::not_converged) || mode.has(ModeFlag::edge);
  c.price_alone = doubtful ? price_alone_doubtful : price_alone_sound;
  return c;
}

/// How far a mode's resonance stands above what all others contribute there, squared, over all outputs: peak
/// |C|/(lambda eta) against |sum_s C_s/(lambda_s(1 + i eta) - lambda)|. The modulus cancels.
double visibility(const Eigen::VectorXd& eigenvalue, const Eigen::MatrixXd& constant, Eigen::Index unit,
                  double loss_factor) {
  const double lambda = eigenvalue[unit];
  Eigen::RowVectorXcd others = Eigen::RowVectorXcd::Zero(constant.cols());
  for (Eigen::Index s = 0; s < eigenvalue.size(); ++s) {
    if (s == unit) continue;
    others += constant.row(s) / std::complex<double>(eigenvalue[s] - lambda, eigenvalue[s] * loss_factor);
  }
  const double peak = constant.row(unit).squaredNorm() / std::pow(lambda * loss_factor, 2);
  return peak > 0.0 ? peak / (others.squaredNorm() + 1e-300) : 0.0;
}

/// The one pole that nearly double modes make: with H_k = sum_r C_rk/(…), the least-squares place of a single
/// pole with constants C_k = sum_r C_rk is the mean weighted by w_r ~ sum_k C_k C_rk. Members that oppose the
/// sum have no weight.
void combine(const ModelModes& model, Explanation& e) {
  e.constant = Eigen::VectorXd::Zero(model.constant.cols());
  for (int r : e.model) e.constant += model.constant.row(r).transpose();
  const auto n = static_cast<Eigen::Index>(e.model.size());
  Eigen::ArrayXd weight(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto row = model.constant.row(e.model[static_cast<std::size_t>(k)]);
    weight[k] = e.constant.size() > 0 ? std::max(0.0, e.constant.dot(row)) : 0.0;
  }
  if (weight.sum() <= 0.0) weight.setOnes();
  weight /= weight.sum();
  const Eigen::ArrayXd eigenvalue = model.eigenvalue(e.model).array();
  e.eigenvalue = (weight * eigenvalue).sum();
  e.ln_eigenvalue = std::log(e.eigenvalue);
  e.spread = std::sqrt((weight * (eigenvalue / e.eigenvalue - 1.0).square()).sum());
}

}  // namespace

PairingCost::PairingCost(const ModeSet& measured, const ModelModes& model, const PairingOptions& options)
    : scales_with_modulus_(model.constant_scales_with_modulus) {
  std::vector<double> loss_factors;
  for (const Mode& mode : measured.modes) {
    candidates_.push_back(candidate_of(mode, measured));
    const Candidate& c = candidates_.back();
    if (c.loss_factor > 0.0) loss_factors.push_back(c.loss_factor);
    reference_ln_f_ += c.ln_f / static_cast<double>(measured.modes.size());
    if (c.constant.size() == 0) continue;
    has_constants_ = true;
    if (c.constant.size() != model.constant.cols()) {
      throw Error(fmt::format("pair_modes: as many modal constants as the model has outputs, got {} and {}",
                              c.constant.size(), model.constant.cols()));
    }
  }
  amplitude_known_ = measured.form != FrfKind::unknown;
  const auto by_frequency = [](const Candidate& a, const Candidate& b) { return a.ln_f < b.ln_f; };
  const auto [lowest, highest] = std::minmax_element(candidates_.begin(), candidates_.end(), by_frequency);
  const bool band_given = options.band_hi_hz > 0.0;
  band_lo_ = band_given ? std::log(std::max(options.band_lo_hz, 1e-300)) : lowest->ln_f;
  band_hi_ = band_given ? std::log(options.band_hi_hz) : highest->ln_f;
  const double loss_factor = loss_factors.empty() ? usual_loss_factor : median(loss_factors);
  // eta = (pi/2) d ln E/d ln f of a purely viscoelastic material; clamps and friction add to eta, so half of
  // it at a guess.
  expected_slope_ = loss_factor / std::numbers::pi;
  const bool several = references_of(measured.outputs).several();
  make_units(model, (several ? inseparable_by_references : inseparable) * loss_factor, loss_factor);
  make_explanations(model);
}

void PairingCost::make_units(const ModelModes& model, double least_step, double loss_factor) {
  for (int r = 0; r < model.eigenvalue.size(); ++r) {
    const bool joined = r > 0 && 0.5 * std::log(model.eigenvalue[r] / model.eigenvalue[r - 1]) < least_step;
    if (joined) {
      units_.back().model.push_back(r);
    } else {
      units_.push_back({{r}, 0.0, 0.0});
    }
  }
  Eigen::VectorXd eigenvalue(static_cast<Eigen::Index>(units_.size()));
  Eigen::MatrixXd constant(eigenvalue.size(), model.constant.cols());
  for (Eigen::Index u = 0; u < eigenvalue.size(); ++u) {
    Explanation whole;
    whole.model = units_[static_cast<std::size_t>(u)].model;
    combine(model, whole);
    eigenvalue[u] = whole.eigenvalue;
    constant.row(u) = whole.constant;
  }
  for (Eigen::Index u = 0; u < eigenvalue.size(); ++u) {
    Unit& unit = units_[static_cast<std::size_t>(u)];
    const double v = visibility(eigenvalue, constant, u, loss_factor);
    unit.ln_eigenvalue = std::log(eigenvalue[u]);
    unit.price_missing = price_missing_visible * v / (1.0 + v);
  }
}

void PairingCost::make_explanations(const ModelModes& model) {
  for (int u = 0; u < static_cast<int>(units_.size()); ++u) {
    const Unit& unit = units_[static_cast<std::size_t>(u)];
    Explanation alone;
    alone.model = unit.model;
    alone.first_unit = u;
    combine(model, alone);
    explanations_.push_back(alone);
    if (u + 1 == static_cast<int>(units_.size())) continue;
    const Unit& next = units_[static_cast<std::size_t>(u + 1)];
    Explanation both = alone;
    both.spacing = 0.5 * (next.ln_eigenvalue - unit.ln_eigenvalue);
    if (both.spacing > 0.5) continue;  // no loss factor makes these one pole
    both.second_unit = u + 1;
    both.model.insert(both.model.end(), next.model.begin(), next.model.end());
    combine(model, both);
    explanations_.push_back(both);
  }
  std::stable_sort(
      explanations_.begin(), explanations_.end(),
      [](const Explanation& a, const Explanation& b) { return a.ln_eigenvalue < b.ln_eigenvalue; });
  explanation_of_unit_.resize(units_.size());
  for (std::size_t i = 0; i < explanations_.size(); ++i) {
    const Explanation& e = explanations_[i];
    explanation_ln_eigenvalue_.push_back(e.ln_eigenvalue);
    if (e.second_unit < 0) explanation_of_unit_[static_cast<std::size_t>(e.first_unit)] = static_cast<int>(i);
  }
}

double PairingCost::ln_frequency(const Law& law, double ln_eigenvalue) const {
  // 2 ln(2 pi) + 2 x = ln E0 + n (x - x0) + ln lambda
  const double ln_two_pi = std::log(2.0 * std::numbers::pi);
  return (law.ln_modulus - law.slope * reference_ln_f_ + ln_eigenvalue - 2.0 * ln_two_pi) / (2.0 - law.slope);
}

double PairingCost::mac(int measured, int index) const {
  const Eigen::VectorXcd& c = candidates_[static_cast<std::size_t>(measured)].constant;
  const Eigen::VectorXd& m = explanation(index).constant;
  if (c.size() == 0) return std::numeric_limits<double>::quiet_NaN();
  const double assured = modal_assurance(m.cast<std::complex<double>>(), c);
  return std::isnan(assured) ? 0.0 : assured;
}

double PairingCost::correlation(const Candidate& measured, const Explanation& explained,
                                const Law& law) const {
  const double lengths = measured.constant.norm() * explained.constant.norm();
  const double product = measured.constant.real().dot(explained.constant);
  return lengths > 0.0 ? (law.reversed ? -product : product) / lengths : 0.0;
}

double PairingCost::ln_strength_ratio(const Candidate& measured, const Explanation& explained,
                                      const Law& law) const {
  const double ln_modulus = law.ln_modulus + law.slope * (measured.ln_f - reference_ln_f_);
  return std::log(measured.constant.norm() / explained.constant.norm()) -
         (scales_with_modulus_ ? ln_modulus : 0.0);
}

double PairingCost::pair_cost(const Candidate& measured, const Explanation& explained, const Law& law,
                              double tolerance) const {
  const double misfit = (measured.ln_f - ln_frequency(law, explained.ln_eigenvalue)) / tolerance;
  double cost = std::log1p(misfit * misfit);  // Cauchy: a law of two parameters is not the whole truth
  if (measured.constant.size() == 0) return cost;
  if (explained.constant.norm() == 0.0) return cost + shape_limit + amplitude_limit;
  const double rho = correlation(measured, explained, law);
  cost += std::min(shape_limit, shape_weight / (1.0 + 20.0 * measured.noise) * (1.0 - rho));
  if (amplitude_known_) {
    const double ln_ratio = ln_strength_ratio(measured, explained, law);
    cost += std::min(amplitude_limit, amplitude_weight * ln_ratio * ln_ratio);
  }
  return cost;
}

PairingCost::Assignment PairingCost::assign(const Law& law, double tolerance, int forbidden_measured,
                                            int forbidden_explanation) const {
  const auto rows = static_cast<Eigen::Index>(candidates_.size());
  const auto unit_count = static_cast<Eigen::Index>(units_.size());
  Assignment result;
  result.explanation.assign(candidates_.size(), -1);
  if (law.reversed) result.cost += price_reversed;
  result.cost += slope_weight * std::pow((law.slope - expected_slope_) / 0.1, 2);

  Eigen::VectorXd price_missing(unit_count);
  for (Eigen::Index u = 0; u < unit_count; ++u) {
    const Unit& unit = units_[static_cast<std::size_t>(u)];
    const bool wanted = in_band(ln_frequency(law, unit.ln_eigenvalue));
    price_missing[u] = wanted ? unit.price_missing : 0.0;
  }
  result.cost += price_missing.sum();

  // The list of model modes ends somewhere; where that is below measured modes, at least as many model modes
  // are missing from it.
  const double highest = highest_ln_frequency(law, tolerance);
  for (const Candidate& c : candidates_) {
    if (c.ln_f > highest) result.cost += price_missing_visible;
  }

  // One column per unit, less what using it saves, and one per measured mode for leaving it alone.
  constexpr double forbidden = 1e6;
  Eigen::MatrixXd cost = Eigen::MatrixXd::Constant(rows, unit_count + rows, forbidden);
  Eigen::MatrixXi chosen = Eigen::MatrixXi::Constant(rows, unit_count, -1);
  const double reach_ln_eigenvalue = reach * tolerance * (2.0 - law.slope);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Candidate& measured = candidates_[static_cast<std::size_t>(i)];
    cost(i, unit_count + i) = measured.price_alone;
    // The eigenvalue that the law would put at the measured frequency, and those in reach of it.
    const double here = (2.0 - law.slope) * (measured.ln_f - ln_frequency(law, 0.0));
    const auto begin = std::lower_bound(explanation_ln_eigenvalue_.begin(), explanation_ln_eigenvalue_.end(),
                                        here - reach_ln_eigenvalue);
    for (auto at = begin; at != explanation_ln_eigenvalue_.end() && *at <= here + reach_ln_eigenvalue; ++at) {
      const int index = static_cast<int>(at - explanation_ln_eigenvalue_.begin());
      const Explanation& e = explanation(index);
      if (e.second_unit >= 0 && e.spacing > confusable * measured.loss_factor) continue;
      if (i == forbidden_measured) {
        const Explanation& other = explanation(forbidden_explanation);
        const auto shares = [&](int unit) {
          return unit >= 0 && (unit == other.first_unit || unit == other.second_unit);
        };
        if (shares(e.first_unit) || shares(e.second_unit)) continue;
      }
      const double c = pair_cost(measured, e, law, tolerance);
      for (int unit : {e.first_unit, e.second_unit}) {
        if (unit < 0 || c - price_missing[unit] >= cost(i, unit)) continue;
        cost(i, unit) = c - price_missing[unit];
        chosen(i, unit) = index;
      }
    }
  }
  std::vector<int> unit_of = cheapest_assignment(cost);
  for (Eigen::Index i = 0; i < rows; ++i) {
    int& column = unit_of[static_cast<std::size_t>(i)];
    result.cost += cost(i, column);
    if (column < unit_count) {
      result.explanation[static_cast<std::size_t>(i)] = chosen(i, column);
    } else {
      column = -1;
    }
  }
  settle_shared_groups(unit_of, result);
  return result;
}

/// A group stands only where one measured mode speaks for it; where another holds its second unit, each has
/// its own.
void PairingCost::settle_shared_groups(const std::vector<int>& unit_of, Assignment& assignment) const {
  for (std::size_t i = 0; i < unit_of.size(); ++i) {
    if (unit_of[i] < 0) continue;
    const Explanation& e = explanation(assignment.explanation[i]);
    if (e.second_unit < 0) continue;
    const int other = unit_of[i] == e.first_unit ? e.second_unit : e.first_unit;
    if (std::find(unit_of.begin(), unit_of.end(), other) == unit_of.end()) continue;
    assignment.explanation[i] = explanation_of_unit_[static_cast<std::size_t>(unit_of[i])];
  }
}

double PairingCost::highest_ln_frequency(const Law& law, double tolerance) const {
  return ln_frequency(law, units_.back().ln_eigenvalue) + reach * tolerance;
}

std::vector<bool> PairingCost::explained_units(const std::vector<int>& used) const {
  std::vector<bool> explained(units_.size(), false);
  for (int index : used) {
    if (index < 0) continue;
    const Explanation& e = explanation(index);
    explained[static_cast<std::size_t>(e.first_unit)] = true;
    if (e.second_unit >= 0) explained[static_cast<std::size_t>(e.second_unit)] = true;
  }
  return explained;
}

double PairingCost::unseen(const Law& law, const std::vector<int>& used) const {
  const std::vector<bool> explained = explained_units(used);
  double count = 0.0;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    if (explained[u] || !in_band(ln_frequency(law, units_[u].ln_eigenvalue))) continue;
    count += units_[u].price_missing / price_missing_visible;
  }
  const double highest = highest_ln_frequency(law, 0.0);
  for (const Candidate& c : candidates_) count += c.ln_f > highest;
  return count;
}

std::vector<int> PairingCost::missing_modes(const Law& law, const std::vector<int>& used) const {
  const std::vector<bool> explained = explained_units(used);
  std::vector<int> missing;
  for (std::size_t u = 0; u < units_.size(); ++u) {
    if (explained[u] || !in_band(ln_frequency(law, units_[u].ln_eigenvalue))) continue;
    missing.insert(missing.end(), units_[u].model.begin(), units_[u].model.end());
  }
  return missing;
}

}  // namespace struna::ident
