#include "ident/band_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "ident/mode_flags.hpp"
#include "ident/mode_groups.hpp"
#include "ident/pole_fit.hpp"
#include "ident/resonance_search.hpp"

namespace struna::ident {
namespace {

constexpr double smallest_loss_factor = 1e-5, largest_loss_factor = 0.5;
constexpr double least_lines = 0.3;         // line spacings in the half-power band
constexpr double least_significance = 6.0;  // of the constants, in standard errors
constexpr double least_background = 3.0;    // the same of a pole outside the band, which nobody claims
constexpr double most_outside = 3.0;        // bandwidths that it may be outside
constexpr double least_share = 0.03;        // of the function around
constexpr double one_pole = 0.05;           // bandwidths: nearer poles count as one
constexpr double parallel = 0.9;            // modal assurance
constexpr double settled = 0.1;  // standard errors, or 1e-4 bandwidths: the last round moves no mode farther
constexpr int most_rounds = 8, most_trials = 3, most_iterations = 20;

// One group's fit with what is needed to judge its poles.
class GroupFit {
 public:
  GroupFit(const TransferFunction& window, const BandFitOptions& options)
      : window_(&window), options_(options) {
    const double span = window.frequency_hz(window.lines() - 1) - window.frequency_hz(0);
    spacing_ = span / static_cast<double>(window.lines() - 1);
  }

  bool can_fit(std::size_t poles) const {
    return 2 * window_->lines() * outputs() >
           static_cast<long>(2 * poles) + outputs() * static_cast<long>(2 * poles + 6);
  }
  void fit(const std::vector<Pole>& poles) {
    PoleFitOptions fit_options;
    fit_options.damping = options_.damping;
    fit_options.sigma_known = options_.sigma_known;
    fit_options.max_iterations = most_iterations;
    fit_ = fit_poles(*window_, poles, fit_options);
  }
  const PoleFit& result() const { return fit_; }
  long outputs() const { return static_cast<long>(window_->outputs.size()); }

  // Variance of the scaled residual that the noise alone would show.
  double scatter() const {
    const double per_dof = fit_.chi_square / static_cast<double>(fit_.degrees_of_freedom);
    return options_.sigma_known ? std::max(1.0, per_dof) : per_dof;
  }
  // What a further pole must take out of the sum of squares.
  double penalty() const {
    const double data = 2.0 * static_cast<double>(window_->lines() * outputs()) / fit_.line_correlation;
    return static_cast<double>(2 + 2 * outputs()) * std::log(data) * scatter() * fit_.line_correlation;
  }

  // Why pole r is no mode; empty when it has support.
  std::string objection(long r) const;
  // Its peak over the function's largest magnitude within a bandwidth, both as norms over the outputs in
  // standard deviations.
  double share(long r) const;
  double significance(long r) const;
  double assurance(long r, long s) const;
  bool is_double(long r) const;
  std::optional<long> worst(long targets) const;

 private:
  std::pair<long, long> lines_around(const Pole& pole, double bandwidths) const {
    const double reach = std::max(bandwidths * bandwidth_hz(pole), 1.01 * spacing_);
    const auto begin = window_->frequency_hz.data(), end = begin + window_->lines();
    const long first = std::lower_bound(begin, end, pole.natural_frequency_hz - reach) - begin;
    const long last = std::upper_bound(begin, end, pole.natural_frequency_hz + reach) - begin;
    return {first, last};
  }
  const Pole& pole(long r) const { return fit_.poles[static_cast<std::size_t>(r)]; }

  const TransferFunction* window_;
  BandFitOptions options_;
  double spacing_;
  PoleFit fit_;
};

double GroupFit::significance(long r) const {
  return std::sqrt(
      (fit_.constant.row(r).cwiseAbs2().array() / fit_.constant_sigma.row(r).array().square()).sum() / 2.0);
}

double GroupFit::share(long r) const {
  const auto [first, last] = lines_around(pole(r), 1.0);
  if (last <= first) return 0.0;
  const double scale = pole_scale(pole(r), options_.damping);
  double largest = 0.0, own = 0.0;
  for (long i = first; i < last; ++i) {
    double total = 0.0, mine = 0.0;
    for (long k = 0; k < outputs(); ++k) {
      const auto& output = window_->outputs[static_cast<std::size_t>(k)];
      total += std::norm(output.value(i) / output.sigma(i));
      mine += std::norm(fit_.constant(r, k) / scale / output.sigma(i));
    }
    largest = std::max(largest, total);
    own = std::max(own, mine);
  }
  return std::sqrt(own / largest);
}

double GroupFit::assurance(long r, long s) const {
  const Eigen::VectorXd weight = fit_.constant_sigma.row(r).transpose().cwiseInverse();
  const Eigen::VectorXcd a =
      fit_.constant.row(r).transpose().cwiseProduct(weight.cast<std::complex<double>>());
  const Eigen::VectorXcd b =
      fit_.constant.row(s).transpose().cwiseProduct(weight.cast<std::complex<double>>());
  return std::norm(a.dot(b)) / (a.squaredNorm() * b.squaredNorm());
}

bool GroupFit::is_double(long r) const {
  const auto [first, last] = lines_around(pole(r), 1.0);
  const long n = std::max(0L, last - first);
  Eigen::VectorXcd g(n);
  for (long i = 0; i < n; ++i)
    g(i) =
        pole_function(pole(r), 2.0 * std::numbers::pi * window_->frequency_hz(first + i), options_.damping);
  Eigen::MatrixXcd alone(n, outputs());
  for (long k = 0; k < outputs(); ++k) {
    const Eigen::VectorXd sigma = window_->outputs[static_cast<std::size_t>(k)].sigma.segment(first, n);
    alone.col(k) = fit_.constant(r, k) * g + fit_.residual.col(k).segment(first, n).cwiseProduct(sigma);
    alone.col(k) /= sigma.mean();
  }
  return looks_double(alone, g);
}

std::string GroupFit::objection(long r) const {
  const Pole& p = pole(r);
  if (p.loss_factor < smallest_loss_factor || p.loss_factor > largest_loss_factor)
    return fmt::format("loss factor {:.3g} outside {:g} to {:g}", p.loss_factor, smallest_loss_factor,
                       largest_loss_factor);
  if (bandwidth_hz(p) < least_lines * spacing_)
    return fmt::format("half-power band {:.3g} Hz far below the line spacing {:.3g} Hz", bandwidth_hz(p),
                       spacing_);
  const double outside = std::max(window_->frequency_hz(0) - p.natural_frequency_hz,
                                  p.natural_frequency_hz - window_->frequency_hz(window_->lines() - 1));
  const bool background = outside > 0.0;
  if (outside > most_outside * bandwidth_hz(p)) return "carried off by the fit";
  if (!(significance(r) > (background ? least_background : least_significance)))
    return fmt::format("modal constants only {:.2g} standard errors", significance(r));
  if (!background && !(share(r) > least_share))
    return fmt::format("only {:.2g} % of the function around it", 100.0 * share(r));
  for (long s = 0; s < static_cast<long>(fit_.poles.size()); ++s) {
    if (s == r || significance(s) < significance(r)) continue;
    const double distance = std::abs(p.natural_frequency_hz - pole(s).natural_frequency_hz);
    const double bandwidth = std::max(bandwidth_hz(p), bandwidth_hz(pole(s)));
    if (distance < one_pole * bandwidth)
      return fmt::format("one with the mode at {:.6g} Hz", pole(s).natural_frequency_hz);
    if (distance < bandwidth && assurance(r, s) > parallel)
      return fmt::format("mends the shape of the mode at {:.6g} Hz", pole(s).natural_frequency_hz);
  }
  return "";
}

// The least significant target with an objection.
std::optional<long> GroupFit::worst(long targets) const {
  std::optional<long> found;
  for (long r = 0; r < targets; ++r)
    if (!objection(r).empty() && (!found || !(significance(r) > significance(*found)))) found = r;
  return found;
}

// Constants from the line next to the resonance: good enough to take a distant mode's share off.
void complete_start(const TransferFunction& tf, Mode& mode, fem::Damping damping) {
  if (mode.modal_constant.size() == static_cast<long>(tf.outputs.size())) return;
  long nearest = 0;
  (tf.frequency_hz.array() - mode.natural_frequency_hz).abs().minCoeff(&nearest);
  const auto g = pole_function(pole_of(mode), 2.0 * std::numbers::pi * tf.frequency_hz(nearest), damping);
  mode.modal_constant.resize(static_cast<long>(tf.outputs.size()));
  for (std::size_t k = 0; k < tf.outputs.size(); ++k)
    mode.modal_constant(static_cast<long>(k)) = tf.outputs[k].value(nearest) / g;
}

// Whether a round left the modes where the one before had them.
bool same(const std::vector<Mode>& before, const std::vector<Mode>& after) {
  if (before.size() != after.size()) return false;
  for (std::size_t r = 0; r < after.size(); ++r)
    if (std::abs(after[r].natural_frequency_hz - before[r].natural_frequency_hz) >
            std::max(settled * after[r].natural_frequency_sigma, 1e-4 * bandwidth_hz(pole_of(after[r]))) ||
        std::abs(after[r].loss_factor - before[r].loss_factor) >
            std::max(settled * after[r].loss_factor_sigma, 1e-4 * after[r].loss_factor))
      return false;
  return true;
}

std::vector<Pole> joined(const std::vector<Pole>& target, const std::vector<Pole>& company) {
  std::vector<Pole> all = target;
  all.insert(all.end(), company.begin(), company.end());
  return all;
}

// A group's fit, its poles dropped and added until nothing objects and nothing is missing.
struct GroupResult {
  std::vector<Mode> modes;
  std::vector<RejectedCandidate> rejected;
  bool changed = false;
};

class GroupRefiner {
 public:
  GroupRefiner(const TransferFunction& window, const ModeGroup& group, const BandFitOptions& options,
               std::vector<Pole>& failed)
      : window_(window), group_(group), options_(options), failed_(failed), fit_(window, options) {}

  GroupResult run(bool search) {
    target_ = group_.target;
    if (!fit_.can_fit(group_.company.size())) return std::move(result_);
    while (!target_.empty() && !fit_.can_fit(target_.size() + group_.company.size()))
      reject(target_.size() - 1, "too few lines");
    fit_.fit(joined(target_, group_.company));
    take_over();
    drop();
    if (search) add();
    for (long r = 0; r < count(); ++r) {
      Mode mode = to_mode(fit_.result(), r, options_.damping);
      if (fit_.is_double(r)) add_flag(mode, ModeFlag::double_mode);
      result_.modes.push_back(std::move(mode));
    }
    return std::move(result_);
  }

 private:
  long count() const { return static_cast<long>(target_.size()); }
  void take_over() { target_.assign(fit_.result().poles.begin(), fit_.result().poles.begin() + count()); }
  void reject(std::size_t r, const std::string& reason) {
    result_.rejected.push_back({target_[r].natural_frequency_hz, reason});
    target_.erase(target_.begin() + static_cast<long>(r));
    result_.changed = true;
  }

  void drop() {
    while (const auto worst = fit_.worst(count())) {
      reject(static_cast<std::size_t>(*worst), fit_.objection(*worst));
      fit_.fit(joined(target_, group_.company));
      take_over();
    }
  }

  void add() {
    int trials = 0;
    while (trials < most_trials) {
      const auto candidate = strongest_pole(window_, fit_.result().residual, group_.territory.lo_hz,
                                            group_.territory.hi_hz, failed_, fit_.penalty());
      if (!candidate || !fit_.can_fit(target_.size() + group_.company.size() + 1)) return;
      ++trials;
      std::vector<Pole> more = target_;
      more.push_back(candidate->pole);
      GroupFit trial(window_, options_);
      trial.fit(joined(more, group_.company));
      const double gain = fit_.result().chi_square - trial.result().chi_square;
      const double f = trial.result().poles[target_.size()].natural_frequency_hz;
      if (!group_.territory.holds(f) || gain < trial.penalty() || trial.worst(count() + 1)) {
        failed_.push_back(candidate->pole);
        continue;
      }
      target_.push_back(candidate->pole);
      fit_ = trial;
      take_over();
      result_.changed = true;
      trials = 0;
    }
  }

  const TransferFunction& window_;
  const ModeGroup& group_;
  BandFitOptions options_;
  std::vector<Pole>& failed_;  // candidates that a trial has refused
  GroupFit fit_;
  std::vector<Pole> target_;
  GroupResult result_;
};

}  // namespace

BandFit fit_band(const TransferFunction& tf, const std::vector<Mode>& start, const BandFitOptions& options) {
  const Span band{tf.frequency_hz(0), tf.frequency_hz(tf.lines() - 1)};
  BandFit result;
  result.modes = start;
  for (Mode& mode : result.modes) complete_start(tf, mode, options.damping);
  sort_by_frequency(result.modes);
  std::vector<Pole> failed;
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<Mode> modes;
    bool changed = false;
    // Poles are added once the others' shares are known well.
    const bool search = options.search_residual && (round > 0 || start.empty());
    for (const ModeGroup& group : group_modes(result.modes, band)) {
      if (group.target.empty() && !search) continue;
      const TransferFunction window = lines_of(tf, group, options.damping);
      GroupResult refined = GroupRefiner(window, group, options, failed).run(search);
      changed = changed || refined.changed;
      modes.insert(modes.end(), refined.modes.begin(), refined.modes.end());
      result.rejected.insert(result.rejected.end(), refined.rejected.begin(), refined.rejected.end());
    }
    sort_by_frequency(modes);
    const bool done = round > 0 && !changed && same(result.modes, modes);
    result.modes = std::move(modes);
    if (done) break;
    if (changed) failed.clear();
  }
  std::erase_if(result.modes, [&](const Mode& mode) {
    if (band.holds(mode.natural_frequency_hz)) return false;
    result.rejected.push_back({mode.natural_frequency_hz, "outside the band"});
    return true;
  });
  return result;
}

}  // namespace struna::ident
