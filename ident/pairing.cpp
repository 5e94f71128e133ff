#include "ident/pairing.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"
#include "ident/pairing_cost.hpp"
#include "ident/pairing_evidence.hpp"
#include "ident/pairing_search.hpp"

namespace struna::ident {
namespace {

using Assignment = PairingCost::Assignment;

constexpr double tolerance = pairing_tolerance;

constexpr double least_gain = 2.0;         // of the evidence, by a pair
constexpr std::ptrdiff_t least_pairs = 3;  // that a doubtful one can be told by
constexpr double rival_margin = 1.5;       // a rival explanation less than this dearer is a rival
constexpr double same_modulus = 0.005;     // rivals closer than this in E widen sigma only
constexpr double least_outlier = 0.02;     // of ln E about its neighbours' trend
constexpr double least_residual = 0.25;    // of the constants about the model's, relative …
constexpr double outlying_residual = 5.0;  // … and over the others' median
constexpr double coupling = 0.003;         // relative error of a stiffness that mixes neighbouring modes

/// An explanation that is nearly as cheap: the margin, and what it would make of the modulus.
struct Rival {
  double margin = 0.0;
  int explanation = -1;  ///< -1: leaving the mode alone
};

Rival rival_of(const PairingCost& cost, const Hypothesis& best, int measured) {
  const Assignment& assignment = best.assignment;
  const int mine = assignment.explanation[static_cast<std::size_t>(measured)];
  const Assignment other = cost.assign(best.law, tolerance, measured, mine);
  return {other.cost - assignment.cost, other.explanation[static_cast<std::size_t>(measured)]};
}

Pair make_pair(const PairingCost& cost, const ModeSet& set, int measured, int index) {
  const Explanation& e = cost.explanation(index);
  const Mode& mode = set.modes[static_cast<std::size_t>(measured)];
  const double f = mode.natural_frequency_hz;
  Pair pair;
  pair.measured = measured;
  pair.model = e.model;
  pair.mac = cost.mac(measured, index);
  pair.modulus = fem::modulus_from_frequency(f, e.eigenvalue);
  const double sigma_f = std::isfinite(mode.natural_frequency_sigma) ? mode.natural_frequency_sigma : 0.0;
  pair.spread = e.spread;  // of two equal ones: half their step in lambda, which is twice that in frequency
  // Where between its members a common pole lies is known to half their deviation.
  pair.modulus_sigma = pair.modulus * std::hypot(2.0 * sigma_f / f, 0.5 * e.spread);
  return pair;
}

/// Deviation of ln E from the trend through all pairs (straight in ln f, curved from six on), by iteratively
/// reweighted least squares with Cauchy weights.
Eigen::VectorXd trend_deviation(const std::vector<Pair>& pairs, const ModeSet& set) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  const Eigen::Index terms = n >= 6 ? 3 : n >= 4 ? 2 : 1;
  Eigen::MatrixXd design(n, terms);
  Eigen::VectorXd ln_e(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pair& pair = pairs[static_cast<std::size_t>(i)];
    const double x =
        std::log(set.modes[static_cast<std::size_t>(pair.measured)].natural_frequency_hz / 100.0);
    for (Eigen::Index k = 0; k < terms; ++k) design(i, k) = std::pow(x, static_cast<double>(k));
    ln_e[i] = std::log(pair.modulus);
  }
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(n);
  Eigen::VectorXd deviation(n);
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Eigen::MatrixXd normal = design.transpose() * weight.asDiagonal() * design;
    const Eigen::VectorXd right = design.transpose() * (weight.asDiagonal() * ln_e);
    deviation = ln_e - design * normal.ldlt().solve(right);
    weight = (1.0 + (deviation.array() / (0.5 * least_outlier)).square()).inverse();
  }
  return deviation;
}

double median_magnitude(const Eigen::VectorXd& v) {
  std::vector<double> magnitude(v.data(), v.data() + v.size());
  for (double& m : magnitude) m = std::abs(m);
  const auto middle = magnitude.begin() + static_cast<std::ptrdiff_t>(magnitude.size() / 2);
  std::nth_element(magnitude.begin(), middle, magnitude.end());
  return *middle;
}

/// Moves pairs whose modulus stands out from the others' trend to the left-out ones, worst first.
void leave_out_outliers(const ModeSet& set, Pairing& pairing) {
  while (pairing.pairs.size() >= 3) {
    const Eigen::VectorXd deviation = trend_deviation(pairing.pairs, set);
    Eigen::Index worst = 0;
    const double largest = deviation.cwiseAbs().maxCoeff(&worst);
    const Pair& pair = pairing.pairs[static_cast<std::size_t>(worst)];
    // 1.48 median |x| is the standard deviation of normal scatter.
    const double limit = std::max(
        {least_outlier, 6.0 * 1.48 * median_magnitude(deviation), 4.0 * pair.modulus_sigma / pair.modulus});
    if (largest <= limit) return;
    pairing.left_out.push_back(
        {pair.measured, fmt::format("unpaired: as model mode {} its modulus would be {:.1f} % off "
                                    "the trend of the others",
                                    pair.model.front() + 1, 100.0 * deviation[worst])});
    pairing.pairs.erase(pairing.pairs.begin() + worst);
  }
}

std::string why_alone(const PairingCost& cost, const Hypothesis& best, int measured) {
  const Assignment& assignment = best.assignment;
  const double here = cost.candidates()[static_cast<std::size_t>(measured)].ln_f;
  double nearest = 1e9;
  int taken_by = -1;
  for (std::size_t j = 0; j < assignment.explanation.size(); ++j) {
    if (assignment.explanation[j] < 0) continue;
    const double there =
        cost.ln_frequency(best.law, cost.explanation(assignment.explanation[j]).ln_eigenvalue);
    if (std::abs(there - here) < nearest) {
      nearest = std::abs(there - here);
      taken_by = static_cast<int>(j);
    }
  }
  if (nearest < 3.0 * tolerance) {
    return fmt::format("unpaired: the model mode nearby ({:.2f} % away) is measured mode {}'s",
                       100.0 * nearest, taken_by + 1);
  }
  return "unpaired: no free model mode fits in frequency and modal constants";
}

/// By how much the evidence falls without this mode's pair.
double gain_of(const PairingCost& cost, const Hypothesis& best, int measured, const PairingOptions& options) {
  std::vector<int> without = best.assignment.explanation;
  without[static_cast<std::size_t>(measured)] = -1;
  return best.evidence - pairing_evidence(cost, best.law, without, options);
}

/// |C/(level E c) - 1|^2 over the outputs that a relative error `coupling` of the stiffness explains: it
/// turns a mode by coupling lambda/(lambda_s - lambda) towards mode s, and the constants, products of two
/// ordinates, by twice that with the root of their ratio.
double mixing(const ModelModes& model, const Explanation& explained) {
  double sum = 0.0;
  for (int s = 0; s < static_cast<int>(model.eigenvalue.size()); ++s) {
    if (std::find(explained.model.begin(), explained.model.end(), s) != explained.model.end()) continue;
    const double step = std::abs(model.eigenvalue[s] / explained.eigenvalue - 1.0);
    const double angle = std::min(1.0, coupling / std::max(step, 1e-12));
    sum += 4.0 * angle * angle * model.constant.row(s).norm() / explained.constant.norm();
  }
  return sum;
}

/// Moves pairs whose constants stand out from the model's, as the others' do not, to the left-out ones: a
/// mode that is none takes the place of a missing one near it.
void leave_out_strange_constants(const PairingCost& cost, const ModelModes& model, const Hypothesis& best,
                                 Pairing& pairing) {
  struct Strange {
    double rho, ln_ratio, allowed;
  };
  std::vector<Strange> list;
  std::vector<double> ratios;
  for (const Pair& pair : pairing.pairs) {
    const auto i = static_cast<std::size_t>(pair.measured);
    const Candidate& measured = cost.candidates()[i];
    const Explanation& explained = cost.explanation(best.assignment.explanation[i]);
    if (measured.constant.size() == 0 || !(explained.constant.norm() > 0.0)) return;
    list.push_back({cost.correlation(measured, explained, best.law),
                    cost.ln_strength_ratio(measured, explained, best.law), mixing(model, explained)});
    ratios.push_back(list.back().ln_ratio);
  }
  if (std::ssize(list) <= least_pairs) return;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  Eigen::VectorXd residual(static_cast<Eigen::Index>(list.size()));
  for (std::size_t k = 0; k < list.size(); ++k) {
    const double length = cost.amplitude_known() ? std::exp(list[k].ln_ratio - *middle) : 1.0;
    const double squared = length * length - 2.0 * length * list[k].rho + 1.0;
    residual[static_cast<Eigen::Index>(k)] = std::sqrt(std::max(0.0, squared));
  }
  const double limit = std::max(least_residual, outlying_residual * median_magnitude(residual));
  for (std::size_t k = list.size(); k-- > 0;) {
    const double off = residual[static_cast<Eigen::Index>(k)];
    if (off * off <= limit * limit + list[k].allowed) continue;
    const Pair& pair = pairing.pairs[k];
    pairing.left_out.push_back(
        {pair.measured,
         fmt::format("unpaired: its modal constants are {:.0f} % off those of model mode {}, "
                     "where the others' are {:.0f} % off",
                     100.0 * off, pair.model.front() + 1, 100.0 * median_magnitude(residual))});
    pairing.pairs.erase(pairing.pairs.begin() + static_cast<std::ptrdiff_t>(k));
  }
}

/// Sorts the best assignment into pairs and modes left out, with the reason.
Pairing verdict(const ModeSet& set, const PairingCost& cost, const ModelModes& model, const Hypothesis& best,
                const PairingOptions& options) {
  const Assignment& assignment = best.assignment;
  Pairing pairing;
  for (int i = 0; i < static_cast<int>(set.modes.size()); ++i) {
    const int index = assignment.explanation[static_cast<std::size_t>(i)];
    if (index < 0) {
      pairing.left_out.push_back({i, why_alone(cost, best, i)});
      continue;
    }
    Pair pair = make_pair(cost, set, i, index);
    const Rival rival = rival_of(cost, best, i);
    const bool no_gain =
        pair_count(assignment) >= least_pairs && gain_of(cost, best, i, options) < least_gain;
    if (no_gain || (rival.margin < rival_margin && rival.explanation < 0)) {
      pairing.left_out.push_back(
          {i, fmt::format("unpaired: model mode {} fits no better than none", pair.model.front() + 1)});
      continue;
    }
    if (rival.margin < rival_margin) {
      const Pair other = make_pair(cost, set, i, rival.explanation);
      const double difference = std::abs(std::log(other.modulus / pair.modulus));
      if (difference > same_modulus) {
        pairing.left_out.push_back({i, fmt::format("ambiguous: model mode {} or {}", pair.model.front() + 1,
                                                   other.model.front() + 1)});
        continue;
      }
      pair.modulus_sigma = std::hypot(pair.modulus_sigma, 0.5 * difference * pair.modulus);
    }
    pairing.pairs.push_back(pair);
  }
  pairing.missing = cost.missing_modes(best.law, assignment.explanation);
  pairing.modulus_slope = best.law.slope;
  pairing.modulus_at_1_hz = std::exp(best.law.ln_modulus - best.law.slope * cost.reference_ln_f());
  pairing.sign_reversed = best.law.reversed;
  leave_out_strange_constants(cost, model, best, pairing);
  leave_out_outliers(set, pairing);
  return pairing;
}

/// How many of the pairs another hypothesis has as well.
std::size_t shared_pairs(const PairingCost& cost, const std::vector<Pair>& pairs, const Hypothesis& other) {
  return static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), [&](const Pair& pair) {
    const int index = other.assignment.explanation[static_cast<std::size_t>(pair.measured)];
    if (index < 0) return false;
    const std::vector<int>& model = cost.explanation(index).model;
    return std::find_first_of(model.begin(), model.end(), pair.model.begin(), pair.model.end()) !=
           model.end();
  }));
}

/// The most probable one of chance and of what pairs at most half of the modes with the same model modes.
RivalPairing most_probable_rival(const PairingCost& cost, const std::vector<Hypothesis>& hypotheses,
                                 const Hypothesis& best, const std::vector<Pair>& pairs) {
  RivalPairing rival;
  double evidence = 0.0;  // of chance
  for (const Hypothesis& other : hypotheses) {
    if (!(other.evidence > evidence) || 2 * shared_pairs(cost, pairs, other) > pairs.size()) continue;
    evidence = other.evidence;
    rival.pairs = static_cast<int>(pair_count(other.assignment));
    rival.modulus = std::exp(other.law.ln_modulus);
  }
  rival.odds = std::exp(evidence - best.evidence);
  return rival;
}

void check(const ModelModes& model) {
  if (model.eigenvalue.size() == 0) throw Error("pair_modes: at least one model mode, got none");
  if (model.constant.rows() != model.eigenvalue.size()) {
    throw Error(fmt::format("pair_modes: one row of constants per model mode, got {} for {}",
                            model.constant.rows(), model.eigenvalue.size()));
  }
  for (Eigen::Index r = 0; r < model.eigenvalue.size(); ++r) {
    const bool ascending = r == 0 || model.eigenvalue[r] >= model.eigenvalue[r - 1];
    if (!(model.eigenvalue[r] > 0.0) || !ascending) {
      throw Error(fmt::format("pair_modes: eigenvalues must be positive and ascending, got {} as number {}",
                              model.eigenvalue[r], r + 1));
    }
  }
}

}  // namespace

void validate(const PairingOptions& options) {
  const auto refuse = [](const char* rule, double lo, double hi) {
    throw Error(fmt::format("pair_modes: {}, got {} and {}", rule, lo, hi));
  };
  if (!(options.modulus_lo > 0.0 && options.modulus_hi > options.modulus_lo)) {
    refuse("0 < modulus_lo < modulus_hi", options.modulus_lo, options.modulus_hi);
  }
  if (!(options.slope_hi > options.slope_lo && options.slope_lo > -2.0 && options.slope_hi < 2.0)) {
    refuse("-2 < slope_lo < slope_hi < 2", options.slope_lo, options.slope_hi);
  }
  const bool band_given = options.band_lo_hz != 0.0 || options.band_hi_hz != 0.0;
  if (band_given && !(options.band_lo_hz >= 0.0 && options.band_hi_hz > options.band_lo_hz)) {
    refuse("0 <= band_lo_hz < band_hi_hz", options.band_lo_hz, options.band_hi_hz);
  }
}

Pairing pair_modes(const ModeSet& measured, const ModelModes& model, const PairingOptions& options) {
  validate(options);
  check(model);
  if (measured.modes.empty()) return {};
  const PairingCost cost(measured, model, options);
  const std::vector<Hypothesis> hypotheses = search_hypotheses(cost, options);
  const Hypothesis& best = hypotheses.front();
  Pairing pairing = verdict(measured, cost, model, best, options);
  pairing.rival = most_probable_rival(cost, hypotheses, best, pairing.pairs);
  return pairing;
}

}  // namespace struna::ident
