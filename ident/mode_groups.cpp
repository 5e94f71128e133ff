#include "ident/mode_groups.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace struna::ident {
namespace {

constexpr std::size_t largest_group = 6;
constexpr double apart = 4.0;  // bandwidths: nearer modes are fitted as one group
// A window's bandwidths either side, which with three residual terms cost a tenth of the accuracy, and its
// lines.
constexpr double window_bandwidths = 15.0, least_lines = 15.0, most_lines = 1000.0;
constexpr double least_gap = 5.0;         // line spacings between windows that are searched by themselves
constexpr double core_bandwidths = 3.0;   // of a neighbour that must not be cut by a window's end
constexpr double model_tolerance = 3e-4;  // of the largest magnitude in the window

// Distance of a mode from the one below it, in their mean bandwidth.
double gap_below(const std::vector<Mode>& modes, std::size_t i) {
  return 2.0 * (modes[i].natural_frequency_hz - modes[i - 1].natural_frequency_hz) /
         (bandwidth_hz(pole_of(modes[i])) + bandwidth_hz(pole_of(modes[i - 1])));
}

// Cuts [first, last) at its widest gaps until what is left together is near each other and not too many.
void split(const std::vector<Mode>& modes, std::size_t first, std::size_t last,
           std::vector<std::size_t>& cuts) {
  if (last - first < 2) return;
  std::size_t cut = first + 1;
  for (std::size_t i = first + 2; i < last; ++i)
    if (gap_below(modes, i) > gap_below(modes, cut)) cut = i;
  if (gap_below(modes, cut) < apart && last - first <= largest_group) return;
  split(modes, first, cut, cuts);
  cuts.push_back(cut);
  split(modes, cut, last, cuts);
}

// Where the groups begin, and the end of the last. Poles outside the band have no lines of their own: they
// stay with the modes next to them.
std::vector<std::size_t> group_bounds(const std::vector<Mode>& modes, const Span& band) {
  std::size_t first = 0, last = modes.size();
  while (first < last && modes[first].natural_frequency_hz < band.lo_hz) ++first;
  while (last > first && modes[last - 1].natural_frequency_hz > band.hi_hz) --last;
  std::vector<std::size_t> bounds = {0};
  split(modes, first, last, bounds);
  bounds.push_back(modes.size());
  return bounds;
}

// Window of modes [first, last): so many bandwidths either side, longer where it would end within a
// neighbour's core.
Span window_of(const std::vector<Mode>& modes, std::size_t first, std::size_t last, const LineBand& band,
               double bandwidths) {
  Span window{modes[first].natural_frequency_hz, modes[last - 1].natural_frequency_hz};
  const auto stretch = [&](const Mode& mode, double so_many) {
    const double f = mode.natural_frequency_hz, reach = so_many * bandwidth_hz(pole_of(mode));
    window.lo_hz = std::min(window.lo_hz, std::max(f - reach, 0.5 * f));  // an octave at most
    window.hi_hz = std::max(window.hi_hz, std::min(f + reach, 2.0 * f));
  };
  for (std::size_t i = first; i < last; ++i) {
    const double line = band.spacing_hz / bandwidth_hz(pole_of(modes[i]));  // in bandwidths
    stretch(modes[i],
            std::min(std::max(bandwidths, least_lines * line), std::max(core_bandwidths, most_lines * line)));
  }
  const Span reach = window;
  const auto touched = [&](const Mode& mode) {
    const double core = core_bandwidths * bandwidth_hz(pole_of(mode));
    return mode.natural_frequency_hz > reach.lo_hz - core && mode.natural_frequency_hz < reach.hi_hz + core;
  };
  for (const Mode& mode : modes)
    if (touched(mode)) stretch(mode, std::min(core_bandwidths, bandwidths));
  const double least = least_lines * band.spacing_hz;
  return {std::max(band.lo_hz, std::min(window.lo_hz, band.hi_hz - least)),
          std::min(band.hi_hz, std::max(window.hi_hz, band.lo_hz + least))};
}

ModeGroup group_of(const std::vector<Mode>& modes, std::size_t first, std::size_t last, const LineBand& band,
                   double bandwidths) {
  const auto middle = [&](std::size_t i) {
    return 0.5 * (modes[i - 1].natural_frequency_hz + modes[i].natural_frequency_hz);
  };
  ModeGroup group;
  group.first = first;
  group.last = last;
  group.window = window_of(modes, first, last, band, bandwidths);
  group.territory = {first == 0 ? band.lo_hz / beyond_band : middle(first),
                     last == modes.size() ? band.hi_hz * beyond_band : middle(last)};
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (i >= first && i < last)
      group.target.push_back(pole_of(modes[i]));
    else if (group.window.holds(modes[i].natural_frequency_hz))
      group.company.push_back(pole_of(modes[i]));
    else
      group.outside.push_back(modes[i]);
  }
  return group;
}

}  // namespace

Pole pole_of(const Mode& mode) {
  return {mode.natural_frequency_hz, mode.loss_factor};
}

void sort_by_frequency(std::vector<Mode>& modes) {
  std::sort(modes.begin(), modes.end(),
            [](const Mode& a, const Mode& b) { return a.natural_frequency_hz < b.natural_frequency_hz; });
}

std::vector<ModeGroup> group_modes(const std::vector<Mode>& modes, const LineBand& band) {
  const std::vector<std::size_t> cuts = group_bounds(modes, band);
  std::vector<ModeGroup> groups;
  double covered = band.lo_hz;
  const auto fill_to = [&](double to_hz) {
    if (to_hz - covered < least_gap * band.spacing_hz) return;  // too few lines to hide a mode
    const double pieces = std::ceil((to_hz - covered) / (most_lines * band.spacing_hz));
    const double length = (to_hz - covered) / std::max(1.0, pieces);
    const double margin = std::max(0.05 * length, 0.5 * least_lines * band.spacing_hz);
    for (double lo = covered; to_hz - lo > 0.5 * length; lo += length) {
      const Span window{std::max(band.lo_hz, lo - margin), std::min(band.hi_hz, lo + length + margin)};
      groups.push_back({{}, {}, modes, {lo, lo + length}, window, 0, 0});
    }
    covered = std::max(covered, to_hz);
  };
  for (std::size_t c = 0; c + 1 < cuts.size() && !modes.empty(); ++c) {
    ModeGroup group = group_of(modes, cuts[c], cuts[c + 1], band, window_bandwidths);
    fill_to(group.window.lo_hz);
    covered = std::max(covered, group.window.hi_hz);
    groups.push_back(std::move(group));
  }
  fill_to(band.hi_hz);
  return groups;
}

ModeGroup with_window(const ModeGroup& group, const std::vector<Mode>& modes, const LineBand& band,
                      double bandwidths) {
  return group_of(modes, group.first, group.last, band, bandwidths);
}

TransferFunction lines_of(const TransferFunction& tf, const ModeGroup& group, fem::Damping damping) {
  TransferFunction window = restrict_band(tf, group.window.lo_hz, group.window.hi_hz);
  for (auto& output : window.outputs) {
    const Eigen::ArrayXd beyond_noise =
        output.value.cwiseAbs2().array() - 9.0 * output.sigma.array().square();
    const double floor = model_tolerance * std::sqrt(std::max(0.0, beyond_noise.maxCoeff()));
    output.sigma = (output.sigma.array().square() + floor * floor).sqrt();
  }
  for (const Mode& mode : group.outside)
    for (std::size_t k = 0; k < window.outputs.size(); ++k)
      for (long i = 0; i < window.lines(); ++i)
        window.outputs[k].value(i) -= modal_share(mode.modal_constant(static_cast<long>(k)), pole_of(mode),
                                                  2.0 * std::numbers::pi * window.frequency_hz(i), damping);
  return window;
}

}  // namespace struna::ident
