#include "ident/pairing.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlopt.hpp>
#include <numbers>

#include "fem/eigenmodes.hpp"
#include "fem/error.hpp"
#include "ident/pairing_cost.hpp"

namespace struna::ident {
namespace {

using Law = PairingCost::Law;
using Assignment = PairingCost::Assignment;

constexpr double wide_tolerance = 0.04;  // relative frequency, while the global search looks for the basin
constexpr double tolerance = 0.012;      // for the verdict: what a power law leaves of a real modulus
constexpr int global_evaluations = 1500;
constexpr int local_evaluations = 150;
constexpr std::size_t starts = 6;
constexpr double distinct_ln_modulus = 0.15;  // between starts
constexpr double rival_margin = 1.5;          // a rival explanation less than this dearer is a rival
constexpr double same_modulus = 0.005;        // rivals closer than this in E widen sigma only
constexpr double least_outlier = 0.02;        // of ln E about its neighbours' trend

struct Trial {
  Law law;
  double cost = 0.0;
};

/// What the objectives see; they must not throw (NLopt would turn that into "nlopt failure").
struct Search {
  const PairingCost* cost = nullptr;
  double tolerance = 0.0;
  bool reversed = false;
  std::vector<Trial> trials;
};

double objective(const std::vector<double>& x, std::vector<double>&, void* data) {
  Search& search = *static_cast<Search*>(data);
  const Law law{x[0], x[1], search.reversed};
  const double cost = search.cost->assign(law, search.tolerance).cost;
  search.trials.push_back({law, cost});
  return cost;
}

/// Runs NLopt; every evaluation is kept in `search`, so that a stop for rounding loses nothing.
void run(nlopt::algorithm algorithm, Search& search, const PairingOptions& options, std::vector<double> start,
         const std::vector<double>& step, int evaluations) {
  const std::vector<double> lower = {std::log(options.modulus_lo), options.slope_lo};
  const std::vector<double> upper = {std::log(options.modulus_hi), options.slope_hi};
  // DIRECT's own arithmetic can land a rounding error outside the box, which NLopt refuses as a start.
  for (std::size_t k = 0; k < start.size(); ++k) start[k] = std::clamp(start[k], lower[k], upper[k]);
  nlopt::opt optimiser(algorithm, 2);
  optimiser.set_lower_bounds(lower);
  optimiser.set_upper_bounds(upper);
  optimiser.set_min_objective(objective, &search);
  optimiser.set_maxeval(evaluations);
  optimiser.set_xtol_abs(std::vector<double>{1e-5, 1e-5});
  if (!step.empty()) optimiser.set_initial_step(step);
  double value = 0.0;
  try {
    optimiser.optimize(start, value);
  } catch (const nlopt::roundoff_limited&) {
  }
}

bool cheaper(const Trial& a, const Trial& b) {
  return a.cost < b.cost;
}

/// The best trials that lie apart in modulus.
std::vector<Trial> distinct_best(std::vector<Trial> trials) {
  std::stable_sort(trials.begin(), trials.end(), cheaper);
  std::vector<Trial> best;
  for (const Trial& trial : trials) {
    const bool known = std::any_of(best.begin(), best.end(), [&](const Trial& other) {
      return std::abs(other.law.ln_modulus - trial.law.ln_modulus) < distinct_ln_modulus;
    });
    if (!known) best.push_back(trial);
    if (best.size() == starts) break;
  }
  return best;
}

/// The level alone, at the slope to expect, in steps that no basin falls between: DIRECT can pass over a
/// narrow one.
void sweep_level(Search& search, const PairingOptions& options) {
  const double slope = std::clamp(search.cost->expected_slope(), options.slope_lo, options.slope_hi);
  std::vector<double> no_gradient;
  for (double level = std::log(options.modulus_lo); level <= std::log(options.modulus_hi);
       level += 1.5 * wide_tolerance) {
    objective({level, slope}, no_gradient, &search);
  }
}

/// Global search with a wide tolerance, then local ones from its best basins with the final tolerance.
Trial search_law(const PairingCost& cost, const PairingOptions& options, bool reversed) {
  Search global{&cost, wide_tolerance, reversed, {}};
  const std::vector<double> middle = {0.5 * std::log(options.modulus_lo * options.modulus_hi),
                                      0.5 * (options.slope_lo + options.slope_hi)};
  sweep_level(global, options);
  run(nlopt::GN_DIRECT_L, global, options, middle, {}, global_evaluations);
  Search local{&cost, tolerance, reversed, {}};
  for (const Trial& start : distinct_best(global.trials)) {
    run(nlopt::LN_SBPLX, local, options, {start.law.ln_modulus, start.law.slope}, {0.05, 0.02},
        local_evaluations);
  }
  return *std::min_element(local.trials.begin(), local.trials.end(), cheaper);
}

/// An explanation that is nearly as cheap: the margin, and what it would make of the modulus.
struct Rival {
  double margin = 0.0;
  int explanation = -1;  ///< -1: leaving the mode alone
};

Rival rival_of(const PairingCost& cost, const Trial& best, const Assignment& assignment, int measured) {
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

std::string why_alone(const PairingCost& cost, const Trial& best, const Assignment& assignment,
                      int measured) {
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

/// Sorts the best assignment into pairs and modes left out, with the reason.
Pairing verdict(const ModeSet& set, const PairingCost& cost, const Trial& best) {
  const Assignment assignment = cost.assign(best.law, tolerance);
  Pairing pairing;
  for (int i = 0; i < static_cast<int>(set.modes.size()); ++i) {
    const int index = assignment.explanation[static_cast<std::size_t>(i)];
    if (index < 0) {
      pairing.left_out.push_back({i, why_alone(cost, best, assignment, i)});
      continue;
    }
    Pair pair = make_pair(cost, set, i, index);
    const Rival rival = rival_of(cost, best, assignment, i);
    if (rival.margin < rival_margin) {
      if (rival.explanation < 0) {
        pairing.left_out.push_back(
            {i, fmt::format("unpaired: model mode {} fits no better than none", pair.model.front() + 1)});
        continue;
      }
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
  leave_out_outliers(set, pairing);
  return pairing;
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
  Trial best = search_law(cost, options, false);
  if (cost.has_constants()) {
    const Trial reversed = search_law(cost, options, true);
    if (cheaper(reversed, best)) best = reversed;
  }
  return verdict(measured, cost, best);
}

}  // namespace struna::ident
