#include "ident/pairing_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlopt.hpp>
#include <numbers>

#include "ident/pairing_evidence.hpp"

namespace struna::ident {
namespace {

using Law = PairingCost::Law;
using Assignment = PairingCost::Assignment;

constexpr double wide_tolerance = 0.04;  // relative frequency, while the global search looks for the basin
constexpr double tolerance = pairing_tolerance;
constexpr int global_evaluations = 1500;
constexpr int local_evaluations = 150;
constexpr std::size_t starts = 6;
constexpr double distinct_ln_modulus = 0.15;  // between starts
constexpr double clear_evidence = 40.0;       // below which …
constexpr std::size_t more_starts = 24;       // … so many starts are followed …
constexpr double coarse = 0.02;               // … relative frequency error of a law not yet refined …
constexpr double near_ln_modulus = 0.08;      // … that may lie as near

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
std::vector<Trial> distinct_best(std::vector<Trial> trials, std::size_t count, double apart) {
  std::stable_sort(trials.begin(), trials.end(), cheaper);
  std::vector<Trial> best;
  for (const Trial& trial : trials) {
    const bool known = std::any_of(best.begin(), best.end(), [&](const Trial& other) {
      return std::abs(other.law.ln_modulus - trial.law.ln_modulus) < apart;
    });
    if (!known) best.push_back(trial);
    if (best.size() == count) break;
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

bool less_probable(const Hypothesis& a, const Hypothesis& b) {
  return a.evidence < b.evidence;
}

/// Global search with a wide tolerance.
std::vector<Trial> search_globally(const PairingCost& cost, const PairingOptions& options, bool reversed) {
  Search global{&cost, wide_tolerance, reversed, {}};
  const std::vector<double> middle = {0.5 * std::log(options.modulus_lo * options.modulus_hi),
                                      0.5 * (options.slope_lo + options.slope_hi)};
  sweep_level(global, options);
  run(nlopt::GN_DIRECT_L, global, options, middle, {}, global_evaluations);
  return std::move(global.trials);
}

/// Local searches from the best basins with the final tolerance.
void follow(const PairingCost& cost, const PairingOptions& options, const std::vector<Trial>& from,
            std::vector<Hypothesis>& hypotheses) {
  for (const Trial& start : from) {
    Search local{&cost, tolerance, start.law.reversed, {}};
    run(nlopt::LN_SBPLX, local, options, {start.law.ln_modulus, start.law.slope}, {0.05, 0.02},
        local_evaluations);
    const Law law = std::min_element(local.trials.begin(), local.trials.end(), cheaper)->law;
    Assignment assignment = cost.assign(law, tolerance);
    const double evidence = pair_count(assignment) > 0
                                ? pairing_evidence(cost, law, assignment.explanation, options)
                                : -std::numeric_limits<double>::infinity();
    hypotheses.push_back({law, std::move(assignment), evidence});
  }
}

/// The same trials, the most probable ones cheapest: where most modes are missing, the price of that hides
/// them behind laws that put no model mode in the band.
std::vector<Trial> by_evidence(const PairingCost& cost, const PairingOptions& options,
                               std::vector<Trial> trials) {
  for (Trial& trial : trials)
    trial.cost = -pairing_evidence(cost, trial.law, cost.assign(trial.law, wide_tolerance).explanation,
                                   options, coarse);
  return trials;
}

}  // namespace

std::ptrdiff_t pair_count(const PairingCost::Assignment& assignment) {
  return std::count_if(assignment.explanation.begin(), assignment.explanation.end(),
                       [](int index) { return index >= 0; });
}

// What a few modes leave open takes more starts than a list that one law explains far better than chance.
std::vector<Hypothesis> search_hypotheses(const PairingCost& cost, const PairingOptions& options) {
  std::vector<std::vector<Trial>> global = {search_globally(cost, options, false)};
  if (cost.has_constants()) global.push_back(search_globally(cost, options, true));
  std::vector<Hypothesis> found;
  for (const auto& trials : global)
    follow(cost, options, distinct_best(trials, starts, distinct_ln_modulus), found);
  const bool clear = std::max_element(found.begin(), found.end(), less_probable)->evidence > clear_evidence;
  for (auto& trials : global) {
    if (clear) break;
    trials = by_evidence(cost, options, std::move(trials));
    follow(cost, options, distinct_best(std::move(trials), more_starts, near_ln_modulus), found);
  }
  std::iter_swap(found.begin(), std::max_element(found.begin(), found.end(), less_probable));
  return found;
}

}  // namespace struna::ident
