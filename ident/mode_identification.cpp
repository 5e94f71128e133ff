#include "ident/mode_identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fem/error.hpp"
#include "ident/band_fit.hpp"
#include "ident/circle_check.hpp"
#include "ident/circle_fit.hpp"
#include "ident/half_power.hpp"
#include "ident/leakage.hpp"
#include "ident/mode_flags.hpp"
#include "ident/noise_floor.hpp"
#include "ident/reference_modes.hpp"
#include "ident/references.hpp"
#include "ident/resonance_search.hpp"
#include "ident/window_damping.hpp"

namespace struna::ident {
namespace {

constexpr std::array<std::pair<ModeMethod, const char*>, 4> method_words = {
    {{ModeMethod::automatic, "auto"},
     {ModeMethod::circle, "circle"},
     {ModeMethod::half_power, "half-power"},
     {ModeMethod::multi, "multi"}}};
constexpr double window_lines = 13.0;       // a window of a bandwidth either side has at least so many lines
constexpr double least_window_lines = 7.0;  // the same where neighbours press
constexpr double most_scatter = 0.08;       // of a circle's radius, beyond noise
constexpr int window_passes = 4;

struct Context {
  TransferFunction tf;  // circle form, band, with sigma
  bool sigma_known = true;
  double spacing_hz = 0.0;
  double lo_hz = 0.0;
  double hi_hz = 0.0;
  ModeOptions options;
};

void check(const ModeOptions& options) {
  if (options.band_lo_hz < 0.0 || (options.band_hi_hz != 0.0 && options.band_hi_hz <= options.band_lo_hz))
    throw Error(fmt::format("identify_modes: band with 0 <= lower < upper, got {}:{}", options.band_lo_hz,
                            options.band_hi_hz));
  for (const auto* list : {&options.frequencies_hz, &options.extra_hz})
    for (const double f : *list)
      if (!(f > 0.0)) throw Error(fmt::format("identify_modes: listed frequencies above 0 Hz, got {}", f));
}

// The lines from the first to the last that stand out of the noise (41 around each, twice): past the
// excitation's band there is nothing to identify. All lines where none does.
TransferFunction without_noisy_ends(const TransferFunction& tf) {
  constexpr long half = 20;
  constexpr double stands_out = 2.0;
  Eigen::ArrayXd power = Eigen::ArrayXd::Zero(tf.lines());
  for (const auto& output : tf.outputs) power += output.value.array().abs2() / output.sigma.array().square();
  power /= 2.0 * static_cast<double>(tf.outputs.size());  // 1 for noise alone
  long first = -1, last = -1;
  for (long i = 0; i < tf.lines(); ++i) {
    const long lo = std::max(0L, i - half), hi = std::min(tf.lines() - 1, i + half);
    std::vector<double> around(power.data() + lo, power.data() + hi + 1);
    std::nth_element(around.begin(), around.begin() + static_cast<long>(around.size() / 2), around.end());
    if (around[around.size() / 2] < stands_out * stands_out) continue;
    if (first < 0) first = i;
    last = i;
  }
  return last - first < 2 * half ? tf : restrict_band(tf, tf.frequency_hz(first), tf.frequency_hz(last));
}

// One entry for what several rounds have refused.
void deduplicate(std::vector<RejectedCandidate>& rejected) {
  std::stable_sort(rejected.begin(), rejected.end(),
                   [](const auto& a, const auto& b) { return a.frequency_hz < b.frequency_hz; });
  const auto end = std::unique(rejected.begin(), rejected.end(), [](const auto& a, const auto& b) {
    return std::abs(a.frequency_hz - b.frequency_hz) < 2e-3 * b.frequency_hz;
  });
  rejected.erase(end, rejected.end());
}

Context prepare(const TransferFunction& tf, const ModeOptions& options) {
  Context context;
  context.options = options;
  // Noise is judged in the form measured, where it is smooth; 1/omega^2 would tilt it steeply at the low end.
  const TransferFunction noisy = with_noise_floor(tf);
  TransferFunction form = to_circle_form(noisy, options.damping);
  if (options.band_hi_hz > 0.0)
    form = restrict_band(form, options.band_lo_hz, options.band_hi_hz);
  else if (options.frequencies_hz.empty() && options.extra_hz.empty())
    form = without_noisy_ends(form);
  if (form.lines() < 5)
    throw Error(fmt::format("identify_modes: at least 5 lines above 0 Hz in the band, got {}; widen the band",
                            form.lines()));
  context.sigma_known = has_sigma(tf);
  context.tf = form;
  context.lo_hz = form.frequency_hz(0);
  context.hi_hz = form.frequency_hz(form.lines() - 1);
  context.spacing_hz = (context.hi_hz - context.lo_hz) / static_cast<double>(form.lines() - 1);
  for (const auto* list : {&options.frequencies_hz, &options.extra_hz})
    for (const double f : *list)
      if (f < context.lo_hz || f > context.hi_hz)
        throw Error(fmt::format("identify_modes: listed frequencies within the band {} to {} Hz, got {}",
                                context.lo_hz, context.hi_hz, f));
  return context;
}

// Peaks, and the user's frequencies where there is no peak within a bandwidth.
std::vector<Pole> candidates(const Context& context) {
  std::vector<Pole> poles = find_peaks(context.tf);
  std::vector<double> damping;
  for (const Pole& pole : poles) damping.push_back(pole.loss_factor);
  std::sort(damping.begin(), damping.end());
  const double typical = damping.empty() ? 0.01 : damping[damping.size() / 2];
  for (const auto* list : {&context.options.frequencies_hz, &context.options.extra_hz})
    for (const double f : *list)
      if (std::none_of(poles.begin(), poles.end(), [&](const Pole& pole) {
            return std::abs(pole.natural_frequency_hz - f) < std::max(bandwidth_hz(pole), context.spacing_hz);
          }))
        poles.push_back({f, std::max(typical, 2.0 * context.spacing_hz / f)});
  std::sort(poles.begin(), poles.end(),
            [](const Pole& a, const Pole& b) { return a.natural_frequency_hz < b.natural_frequency_hz; });
  return poles;
}

struct Window {
  double lo_hz = 0.0;
  double hi_hz = 0.0;
};

// A bandwidth either side, more where lines are coarse (the arc's ends then pin the residual), not past the
// middle between neighbours; seven lines all the same.
Window window_around(const Context& context, const Pole& pole, double left_hz, double right_hz) {
  const double f = pole.natural_frequency_hz;
  const double least = 0.5 * least_window_lines * context.spacing_hz;
  const double reach = std::max(bandwidth_hz(pole), 0.5 * window_lines * context.spacing_hz);
  Window window;
  window.lo_hz = std::min(f - least, std::max(f - reach, 0.5 * (left_hz + f)));
  window.hi_hz = std::max(f + least, std::min(f + reach, 0.5 * (right_hz + f)));
  window.lo_hz = std::max(context.lo_hz, std::min(window.lo_hz, context.hi_hz - 2.0 * least));
  window.hi_hz = std::min(context.hi_hz, std::max(window.hi_hz, context.lo_hz + 2.0 * least));
  return window;
}

// Circle fits from a start pole, the window following the fit until it stays.
Mode circle_of(const Context& context, Pole pole, double left_hz, double right_hz) {
  CircleFitOptions options;
  options.damping = context.options.damping;
  options.sigma_known = context.sigma_known;
  Mode mode;
  for (int pass = 0; pass < window_passes; ++pass) {
    const Window window = window_around(context, pole, left_hz, right_hz);
    mode = fit_circle(context.tf, pole.natural_frequency_hz, window.lo_hz, window.hi_hz, options);
    const bool inside = mode.natural_frequency_hz > window.lo_hz && mode.natural_frequency_hz < window.hi_hz;
    if (!inside) break;
    const Pole next{mode.natural_frequency_hz,
                    std::clamp(mode.loss_factor, 0.5 * pole.loss_factor, 2.0 * pole.loss_factor)};
    const bool stays =
        std::abs(next.loss_factor - pole.loss_factor) < 0.1 * pole.loss_factor &&
        std::abs(next.natural_frequency_hz - pole.natural_frequency_hz) < 0.1 * bandwidth_hz(pole);
    pole = next;
    if (stays) break;
  }
  return mode;
}

// Why a single-mode fit is no mode; empty when it may be one.
std::string objection(const Context& context, const Mode& mode) {
  if (mode.natural_frequency_hz <= mode.window_lo_hz || mode.natural_frequency_hz >= mode.window_hi_hz)
    return "no resonance in its window";
  if (!(mode.loss_factor > 1e-5 && mode.loss_factor < 0.5))
    return fmt::format("loss factor {:.3g} outside 1e-5 to 0.5", mode.loss_factor);
  if (mode.loss_factor * mode.natural_frequency_hz < 0.3 * context.spacing_hz)
    return fmt::format("half-power band {:.3g} Hz far below the line spacing {:.3g} Hz",
                       mode.loss_factor * mode.natural_frequency_hz, context.spacing_hz);
  if (mode.loss_factor_sigma > 0.3 * mode.loss_factor) return "drowned in noise";
  return "";
}

// The same, and a circle that is none: scatter that noise does not explain, in every output.
std::string objection_to_circle(const Context& context, const Mode& mode) {
  const auto best = std::min_element(mode.circles.begin(), mode.circles.end(),
                                     [](const Circle& a, const Circle& b) { return a.scatter < b.scatter; });
  if (mode.has(ModeFlag::poor_circle) && best->scatter > most_scatter)
    return fmt::format("no circle: scatter {:.0f} % of the radius", 100.0 * best->scatter);
  return objection(context, mode);
}

// The narrowest start that leads to a mode: noise on a peak makes its flanks look steeper than they are.
Mode sound_circle_of(const Context& context, const Pole& pole, double left_hz, double right_hz) {
  Mode first = circle_of(context, pole, left_hz, right_hz);
  if (objection(context, first).empty()) return first;
  for (const double wider : {2.0, 4.0}) {
    const Pole start{pole.natural_frequency_hz, std::min(0.4, wider * pole.loss_factor)};
    Mode mode = circle_of(context, start, left_hz, right_hz);
    if (objection(context, mode).empty()) return mode;
  }
  return first;
}

std::vector<Mode> circles_of(const Context& context, const std::vector<Pole>& poles) {
  std::vector<Mode> modes;
  for (std::size_t r = 0; r < poles.size(); ++r) {
    const double left = r > 0 ? poles[r - 1].natural_frequency_hz : 0.0;
    const double right =
        r + 1 < poles.size() ? poles[r + 1].natural_frequency_hz : std::numeric_limits<double>::infinity();
    modes.push_back(sound_circle_of(context, poles[r], left, right));
  }
  return modes;
}

void single_mode_fits(const Context& context, const std::vector<Pole>& poles, ModeSet& set) {
  if (context.options.method == ModeMethod::circle) {
    set.modes = circles_of(context, poles);
  } else {
    for (std::size_t r = 0; r < poles.size(); ++r) {
      const double left =
          r > 0 ? 0.5 * (poles[r - 1].natural_frequency_hz + poles[r].natural_frequency_hz) : 0.0;
      const double right = r + 1 < poles.size()
                               ? 0.5 * (poles[r + 1].natural_frequency_hz + poles[r].natural_frequency_hz)
                               : context.hi_hz;
      set.modes.push_back(
          fit_half_power(context.tf, poles[r].natural_frequency_hz, left, right, context.options.damping));
    }
  }
  std::erase_if(set.modes, [&](const Mode& mode) {
    const std::string reason =
        mode.circles.empty() ? objection(context, mode) : objection_to_circle(context, mode);
    if (!reason.empty()) set.rejected.push_back({mode.natural_frequency_hz, reason});
    return !reason.empty();
  });
  if (context.options.method == ModeMethod::circle)
    judge_circles(context.tf, context.options.damping, context.sigma_known, set.modes);
}

// The circles of a multi-mode fit's modes, each from its own pole: they illustrate.
void attach_circles(const Context& context, std::vector<Mode>& modes) {
  std::vector<Pole> poles;
  for (const Mode& mode : modes) poles.push_back({mode.natural_frequency_hz, mode.loss_factor});
  const std::vector<Mode> circles = circles_of(context, poles);
  for (std::size_t r = 0; r < modes.size(); ++r) {
    if (!objection(context, circles[r]).empty()) continue;
    modes[r].circle_natural_frequency_hz = circles[r].circle_natural_frequency_hz;
    modes[r].circle_loss_factor = circles[r].circle_loss_factor;
    modes[r].circles = circles[r].circles;
    modes[r].window_lo_hz = circles[r].window_lo_hz;
    modes[r].window_hi_hz = circles[r].window_hi_hz;
  }
}

// Whether a listed frequency has no candidate nearer than this one.
bool is_listed(const Context& context, const std::vector<Pole>& poles, std::size_t r) {
  const auto distance = [](const Pole& pole, double f) { return std::abs(pole.natural_frequency_hz - f); };
  for (const auto* list : {&context.options.frequencies_hz, &context.options.extra_hz})
    for (const double f : *list)
      if (std::all_of(poles.begin(), poles.end(),
                      [&](const Pole& other) { return distance(poles[r], f) <= distance(other, f); }))
        return true;
  return false;
}

// Circle fits of the candidates start the multi-mode fit. One that makes no circle is left to the search of
// the residual, unless the user listed it.
void multi_mode_fits(const Context& context, const std::vector<Pole>& poles, ModeSet& set) {
  std::vector<Mode> start;
  std::vector<Mode> circles = circles_of(context, poles);
  for (std::size_t r = 0; r < poles.size(); ++r) {
    if (objection_to_circle(context, circles[r]).empty()) {
      start.push_back(std::move(circles[r]));
    } else if (is_listed(context, poles, r)) {
      start.emplace_back();
      start.back().natural_frequency_hz = poles[r].natural_frequency_hz;
      start.back().loss_factor = poles[r].loss_factor;
    }
  }
  set.stabilisation = stabilise(context.tf, {.damping = context.options.damping});
  BandFitOptions options;
  options.damping = context.options.damping;
  options.sigma_known = context.sigma_known;
  for (const StableColumn& column : set.stabilisation.columns) options.candidates.push_back(column.pole);
  BandFit fit = fit_band(context.tf, start, options);
  set.modes = std::move(fit.modes);
  set.rejected = std::move(fit.rejected);
  const References references = references_of(output_names(context.tf));
  if (references.several())
    set.modes = refine_with_references(context.tf, references, set.modes,
                                       {context.options.damping, context.sigma_known});
  for (Mode& mode : set.modes) {
    const OrderCount count = orders_of(set.stabilisation, {mode.natural_frequency_hz, mode.loss_factor});
    mode.stable_orders = count.standing;
    mode.orders = count.of;
  }
  if (context.options.method == ModeMethod::automatic) attach_circles(context, set.modes);
}

// Only the modes nearest to the user's frequencies, each within a bandwidth of its own.
void keep_listed(const std::vector<double>& frequencies_hz, ModeSet& set) {
  std::vector<Mode> kept;
  std::vector<RejectedCandidate> rejected;
  for (const double f : frequencies_hz) {
    const auto nearest =
        std::min_element(set.modes.begin(), set.modes.end(), [&](const Mode& a, const Mode& b) {
          return std::abs(a.natural_frequency_hz - f) < std::abs(b.natural_frequency_hz - f);
        });
    if (nearest == set.modes.end() ||
        std::abs(nearest->natural_frequency_hz - f) > nearest->loss_factor * nearest->natural_frequency_hz) {
      const auto why =
          std::min_element(set.rejected.begin(), set.rejected.end(), [&](const auto& a, const auto& b) {
            return std::abs(a.frequency_hz - f) < std::abs(b.frequency_hz - f);
          });
      rejected.push_back(
          {f, why == set.rejected.end() ? "no mode near it" : "no mode near it: " + why->reason});
      continue;
    }
    kept.push_back(*nearest);
    set.modes.erase(nearest);
  }
  std::sort(kept.begin(), kept.end(),
            [](const Mode& a, const Mode& b) { return a.natural_frequency_hz < b.natural_frequency_hz; });
  set.modes = std::move(kept);
  set.rejected = std::move(rejected);
}

// Outputs that are zero on every line of the band (a direction that does not move): they tell nothing, and
// there is no noise to weigh them by.
std::vector<bool> silent_outputs(const TransferFunction& tf, const ModeOptions& options) {
  const double hi_hz = options.band_hi_hz > 0.0 ? options.band_hi_hz : tf.frequency_hz.maxCoeff();
  std::vector<bool> silent;
  for (const auto& output : tf.outputs) {
    long lines = 0, zeros = 0;
    for (long i = 0; i < tf.lines(); ++i) {
      if (tf.frequency_hz(i) < options.band_lo_hz || tf.frequency_hz(i) > hi_hz) continue;
      ++lines;
      zeros += output.value(i) == 0.0 ? 1 : 0;
    }
    silent.push_back(lines > 0 && zeros == lines);
  }
  return silent;
}

TransferFunction without(const std::vector<bool>& silent, const TransferFunction& tf) {
  TransferFunction rest = tf;
  rest.outputs.clear();
  for (std::size_t k = 0; k < silent.size(); ++k)
    if (!silent[k]) rest.outputs.push_back(tf.outputs[k]);
  return rest;
}

// Constants and circles of nothing for the outputs left out, so that a mode has one for every output.
void insert_silent(const std::vector<bool>& silent, Mode& mode) {
  Mode whole = mode;
  whole.modal_constant.setZero(static_cast<long>(silent.size()));
  whole.modal_constant_sigma.setZero(static_cast<long>(silent.size()));
  if (!mode.circles.empty()) whole.circles.assign(silent.size(), {});
  std::size_t from = 0;
  for (std::size_t k = 0; k < silent.size(); ++k) {
    if (silent[k]) continue;
    whole.modal_constant(static_cast<long>(k)) = mode.modal_constant(static_cast<long>(from));
    whole.modal_constant_sigma(static_cast<long>(k)) = mode.modal_constant_sigma(static_cast<long>(from));
    if (!mode.circles.empty()) whole.circles[k] = mode.circles[from];
    ++from;
  }
  mode = std::move(whole);
}

ModeSet identify_speaking(const TransferFunction& tf, const ModeOptions& options) {
  const Context context = prepare(tf, options);
  ModeSet set;
  const std::vector<Pole> poles = candidates(context);
  if (options.method == ModeMethod::circle || options.method == ModeMethod::half_power)
    single_mode_fits(context, poles, set);
  else
    multi_mode_fits(context, poles, set);
  deduplicate(set.rejected);
  flag_modes(set.modes, context.spacing_hz, tf.leakage_hz, context.lo_hz, context.hi_hz);
  if (!options.frequencies_hz.empty()) keep_listed(options.frequencies_hz, set);
  for (Mode& mode : set.modes) take_out_leakage(mode, tf.leakage_hz, options.damping);
  take_out_window_damping(tf.exponential_decay, options.damping, set);
  return set;
}

}  // namespace

ModeMethod mode_method(const std::string& word) {
  std::string understood;
  for (const auto& [method, known] : method_words) {
    if (word == known) return method;
    understood += (understood.empty() ? "" : ", ") + std::string(known);
  }
  throw Error(fmt::format("mode method \"{}\" is not known; understood: {}", word, understood));
}

std::string to_string(ModeMethod method) {
  for (const auto& [known, word] : method_words)
    if (known == method) return word;
  throw Error("to_string(ModeMethod): not a method");
}

ModeSet identify_modes(const TransferFunction& tf, const ModeOptions& options) {
  check(options);
  const std::vector<bool> silent = silent_outputs(tf, options);
  const TransferFunction speaking = without(silent, tf);
  if (speaking.outputs.empty())
    throw Error("identify_modes: an output that is not zero on every line of the band, got none");
  ModeSet set = identify_speaking(speaking, options);
  for (Mode& mode : set.modes) insert_silent(silent, mode);
  set.damping = options.damping;
  const TransferFunction form = to_circle_form(tf, options.damping);
  set.form = form.outputs.front().kind;
  for (const auto& output : form.outputs) {
    set.outputs.push_back(output.name);
    set.units.push_back(output.unit);
  }
  return set;
}

}  // namespace struna::ident
