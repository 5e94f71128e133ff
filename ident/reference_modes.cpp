#include "ident/reference_modes.hpp"

#include <algorithm>
#include <cmath>

#include "ident/group_fit.hpp"
#include "ident/modal_assurance.hpp"
#include "ident/mode_flags.hpp"
#include "ident/rank_one_fit.hpp"
#include "ident/schwarz_penalty.hpp"

namespace struna::ident {
namespace {

constexpr int rounds = 2;                   // of all groups: the others' shares follow their new modes
constexpr int most_splits = 3;              // in a group
constexpr double may_be_one = 0.3;          // bandwidths, between poles that are tried as one
constexpr double parallel = 0.98;           // assurance of two shapes
constexpr double least_significance = 6.0;  // of the constants, in standard errors
constexpr double smallest_loss_factor = 1e-5, largest_loss_factor = 0.5;
// Of the rank test: standard deviations of chi-square, and more, above what noise makes (one in ten
// thousand).
constexpr double least_deviation = 4.0, least_excess = 8.0;
constexpr double windows[] = {15.0, 8.0, 5.0, 3.0};    // bandwidths either side, while noise does not explain
constexpr double lack_of_fit = 2.0, structured = 4.0;  // as band_fit
constexpr int most_weighings = 4;

// A group's lines with what is known of them.
struct Window {
  TransferFunction lines;
  PoleFit free;
};

double lack(const PoleFit& fit) {
  return fit.chi_square / static_cast<double>(fit.degrees_of_freedom);
}

class Refiner {
 public:
  Refiner(const TransferFunction& tf, const References& references, const ReferenceModesOptions& options)
      : tf_(tf), references_(references), band_(band_of(tf)) {
    fit_options_.damping = options.damping;
    fit_options_.sigma_known = options.sigma_known;
  }

  std::vector<Mode> refine(const ModeGroup& group, const std::vector<Mode>& modes) const {
    std::vector<Mode> unchanged(modes.begin() + static_cast<long>(group.first),
                                modes.begin() + static_cast<long>(group.last));
    const std::optional<Window> window = window_of(group, modes);
    if (!window) return unchanged;
    Found best = started(*window, static_cast<long>(group.target.size()));
    join(*window, best);
    for (int i = 0; i < most_splits && split(*window, best); ++i) {
    }
    std::vector<Mode> found;
    for (long r = 0; r < best.targets; ++r) {
      if (!has_support(best.fit, r)) return unchanged;
      found.push_back(to_mode(best.fit, r, fit_options_.damping));
      if (best.fit.rank_excess(r) > limit()) add_flag(found.back(), ModeFlag::double_mode);
    }
    for (long r = 0; r < best.targets; ++r)
      for (long s = r + 1; s < best.targets; ++s)
        if (may_be_one_that_moved(best.fit, r, s))
          for (const long t : {r, s}) add_flag(found[static_cast<std::size_t>(t)], ModeFlag::close_modes);
    return found;
  }

 private:
  struct Found {
    RankOneFit fit;
    long targets;  // poles in front of the company
  };

  // The widest in which free constants explain the lines, else the narrowest; what they do not explain there
  // counts as noise.
  std::optional<Window> window_of(const ModeGroup& group, const std::vector<Mode>& modes) const {
    Window window;
    for (const double bandwidths : windows) {
      const ModeGroup narrowed = with_window(group, modes, band_, bandwidths);
      window.lines = lines_of(tf_, narrowed, fit_options_.damping);
      std::vector<Pole> poles = group.target;
      poles.insert(poles.end(), narrowed.company.begin(), narrowed.company.end());
      const GroupFit room(window.lines, narrowed.outside, band_, fit_options_);
      if (!room.can_fit(poles.size() + 1)) return std::nullopt;
      window.free = fit_poles(window.lines, poles, fit_options_);
      if (lack(window.free) < lack_of_fit && window.free.line_correlation < structured) return window;
    }
    const TransferFunction noise = window.lines;
    for (int pass = 0; pass < most_weighings && lack(window.free) > lack_of_fit; ++pass) {
      weigh_model_error(noise, window.free.residual, window.lines);
      window.free = fit_poles(window.lines, window.free.poles, fit_options_);
    }
    return window;
  }

  Found started(const Window& window, long targets) const {
    const Eigen::MatrixXcd along =
        dominant_participation(references_, window.free.constant, window.free.constant_sigma);
    return {fit_rank_one(window.lines, references_, window.free.poles, along, fit_options_), targets};
  }

  double penalty(const Window& window, const Found& found) const {
    const long outputs = references_.column.rows(), inputs = references_.column.cols();
    const double data =
        2.0 * static_cast<double>(window.lines.lines()) * static_cast<double>(window.lines.outputs.size());
    const double scatter = fit_options_.sigma_known ? std::max(1.0, lack(found.fit)) : lack(found.fit);
    return schwarz_penalty(
        {static_cast<double>(2 + 2 * outputs + 2 * (inputs - 1)), data, found.fit.line_correlation, scatter});
  }

  // Rank excess beyond which it is not noise.
  double limit() const {
    const double freedom =
        2.0 * static_cast<double>((references_.column.rows() - 1) * (references_.column.cols() - 1));
    return freedom + least_deviation * std::sqrt(2.0 * freedom) + least_excess;
  }

  bool has_support(const RankOneFit& fit, long r) const {
    const Pole& pole = fit.poles[static_cast<std::size_t>(r)];
    const double significance = std::sqrt(
        (fit.constant.row(r).cwiseAbs2().array() / fit.constant_sigma.row(r).array().square()).sum() / 2.0);
    return significance > least_significance && pole.loss_factor > smallest_loss_factor &&
           pole.loss_factor < largest_loss_factor;
  }

  // Of two poles' shapes over the outputs, each constant over its sigma, in the reference that shows both
  // best.
  double assurance(const RankOneFit& fit, long r, long s) const {
    const Eigen::VectorXd both =
        fit.participation.col(r).cwiseAbs().cwiseMin(fit.participation.col(s).cwiseAbs());
    long j = 0;
    both.maxCoeff(&j);
    Eigen::VectorXcd a(references_.column.rows()), b = a;
    for (long o = 0; o < a.size(); ++o) {
      const int k = references_.column(o, j);
      a(o) = k < 0 ? 0.0 : fit.constant(r, k);
      b(o) = k < 0 ? 0.0 : fit.constant(s, k);
    }
    const double assured = modal_assurance(a, b);
    return std::isnan(assured) ? 1.0 : assured;  // nothing tells them apart
  }

  // Neighbours within a bandwidth that look alike: the set-up may have moved one mode between the references.
  bool may_be_one_that_moved(const RankOneFit& fit, long r, long s) const {
    const Pole &a = fit.poles[static_cast<std::size_t>(r)], &b = fit.poles[static_cast<std::size_t>(s)];
    return std::abs(a.natural_frequency_hz - b.natural_frequency_hz) <
               std::max(bandwidth_hz(a), bandwidth_hz(b)) &&
           assurance(fit, r, s) > parallel;
  }

  // Poles r .. replaced in `poles` and `along` by others.
  RankOneFit trial(const Window& window, const RankOneFit& fit, const std::vector<long>& taken,
                   const PolePair& put) const {
    std::vector<Pole> poles = put.poles;
    std::vector<long> rest;
    for (long r = 0; r < static_cast<long>(fit.poles.size()); ++r)
      if (std::count(taken.begin(), taken.end(), r) == 0) rest.push_back(r);
    for (const long r : rest) poles.push_back(fit.poles[static_cast<std::size_t>(r)]);
    Eigen::MatrixXcd along(fit.participation.rows(), static_cast<long>(poles.size()));
    along << put.participation, fit.participation(Eigen::all, rest);
    return fit_rank_one(window.lines, references_, poles, along, fit_options_);
  }

  bool split(const Window& window, Found& best) const {
    std::vector<long> order;
    for (long r = 0; r < best.targets; ++r)
      if (best.fit.rank_excess(r) > limit()) order.push_back(r);
    std::sort(order.begin(), order.end(),
              [&](long a, long b) { return best.fit.rank_excess(a) > best.fit.rank_excess(b); });
    for (const long r : order) {
      const PolePair pair = split_pole(window.lines, references_, best.fit.poles, r, fit_options_);
      const RankOneFit fit = trial(window, best.fit, {r}, pair);
      const bool gains = best.fit.chi_square - fit.chi_square > penalty(window, {fit, 0});
      const bool distinct = references_.column.rows() == 1 || assurance(fit, 0, 1) < parallel;
      if (!gains || !distinct || !has_support(fit, 0) || !has_support(fit, 1)) continue;
      best = {fit, best.targets + 1};
      return true;
    }
    return false;
  }

  // Tries pairs of near poles from the pencil about their middle, which is the better start, and as one.
  void join(const Window& window, Found& best) const {
    for (long r = 0; r < best.targets; ++r)
      for (long s = r + 1; s < best.targets; ++s) {
        const Pole &a = best.fit.poles[static_cast<std::size_t>(r)],
                   &b = best.fit.poles[static_cast<std::size_t>(s)];
        const double distance = std::abs(a.natural_frequency_hz - b.natural_frequency_hz) /
                                std::max(bandwidth_hz(a), bandwidth_hz(b));
        if (distance > 1.0) continue;
        const Pole middle{0.5 * (a.natural_frequency_hz + b.natural_frequency_hz),
                          0.5 * (a.loss_factor + b.loss_factor)};
        std::vector<Pole> fewer = {middle};
        for (long t = 0; t < static_cast<long>(best.fit.poles.size()); ++t)
          if (t != r && t != s) fewer.push_back(best.fit.poles[static_cast<std::size_t>(t)]);
        const PolePair pair = split_pole(window.lines, references_, fewer, 0, fit_options_);
        const RankOneFit again = trial(window, best.fit, {r, s}, pair);
        if (again.chi_square < best.fit.chi_square && has_support(again, 0) && has_support(again, 1))
          best.fit = again;
        if (distance > may_be_one) return;
        const RankOneFit one = trial(window, best.fit, {r, s}, {{middle}, pair.participation.leftCols(1)});
        if (one.chi_square - best.fit.chi_square < penalty(window, best)) best = {one, best.targets - 1};
        return;
      }
  }

  const TransferFunction& tf_;
  const References& references_;
  LineBand band_;
  PoleFitOptions fit_options_;
};

}  // namespace

std::vector<Mode> refine_with_references(const TransferFunction& tf, const References& references,
                                         const std::vector<Mode>& modes,
                                         const ReferenceModesOptions& options) {
  const Refiner refiner(tf, references, options);
  std::vector<Mode> current = modes;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Mode> next;
    for (const ModeGroup& group : group_modes(current, band_of(tf))) {
      if (group.target.empty()) continue;
      const auto found = refiner.refine(group, current);
      next.insert(next.end(), found.begin(), found.end());
    }
    sort_by_frequency(next);
    current = std::move(next);
  }
  return current;
}

}  // namespace struna::ident
