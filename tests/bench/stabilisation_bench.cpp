// Stabilisation analysis: stable columns against the modes, 40 seeds each, one thread. Rows: set, knob (noise
// in % of the rms; of the peak for pairs), order, value (columns at a mode and columns at none, per set),
// error (rms of frequency in % of the bandwidth, of loss factor in %), time [ms] (shortest of several runs).
// Advice: order 14 tells all modes of the eight-mode set for half the time of the fit; more
// orders cost time and tell no more.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ident/mode.hpp"
#include "ident/noise_floor.hpp"
#include "ident/stabilisation.hpp"
#include "tests/bench/stopwatch.hpp"
#include "tests/ident/simulated_modes.hpp"

namespace {

using namespace struna;
using namespace struna::ident;
using simulated::SimulatedMode;

constexpr unsigned seeds = 40;

// Of which a column is within a quarter of the bandwidth.
struct Score {
  double found = 0.0, extra = 0.0, frequency = 0.0, loss_factor = 0.0;
};

void add(const Stabilisation& told, const std::vector<SimulatedMode>& modes, Score& score) {
  std::size_t met = 0;
  std::vector<const StableColumn*> taken;
  for (const SimulatedMode& mode : modes) {
    const double bandwidth = bandwidth_hz(mode.pole);
    double nearest = bandwidth, loss_factor = 0.0;
    const StableColumn* best = nullptr;
    for (const StableColumn& column : told.columns) {
      const double off = column.pole.natural_frequency_hz - mode.pole.natural_frequency_hz;
      if (std::abs(off) < std::abs(nearest)) {
        nearest = off;
        best = &column;
        loss_factor = column.pole.loss_factor / mode.pole.loss_factor - 1.0;
      }
    }
    if (std::abs(nearest) > 0.25 * bandwidth || std::count(taken.begin(), taken.end(), best) > 0) continue;
    taken.push_back(best);
    ++met;
    score.frequency += nearest * nearest / (bandwidth * bandwidth);
    score.loss_factor += loss_factor * loss_factor;
  }
  score.found += static_cast<double>(met);
  score.extra += static_cast<double>(told.columns.size() - std::min(told.columns.size(), met));
}

template <class Make>
void row(const std::string& name, double level, int order, const std::vector<SimulatedMode>& modes,
         Make make) {
  StabilisationOptions options;
  options.max_order = order;
  Score score;
  for (unsigned seed = 1; seed <= seeds; ++seed) add(stabilise(make(seed), options), modes, score);
  const TransferFunction tf = make(1);
  Stabilisation told;
  const double seconds = tests::best_seconds(9, [&] { told = stabilise(tf, options); });
  const double hits = std::max(1.0, score.found);
  fmt::print("{:<26}{:>8g}{:>7}{:>9.2f}{:>8.2f}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, 100.0 * level, order,
             score.found / seeds, score.extra / seeds, 100.0 * std::sqrt(score.frequency / hits),
             100.0 * std::sqrt(score.loss_factor / hits), 1e3 * seconds);
}

std::vector<SimulatedMode> pair_of(double spacing) {
  std::vector<SimulatedMode> modes = {{{300.0, 0.02}, {1.0, 0.4, -0.6}},
                                      {{300.0 + 6.0 * spacing, 0.02}, {0.5, -1.0, 0.8}}};
  for (SimulatedMode& mode : modes)
    for (auto& constant : mode.constant) constant *= pole_scale(mode.pole, fem::Damping::structural);
  return modes;
}

}  // namespace

int main() {
  fmt::print("{:<26}{:>8}{:>7}{:>9}{:>8}{:>10}{:>10}{:>10}\n", "set", "noise %", "order", "at mode",
             "at none", "f [% bw]", "eta [%]", "time [ms]");
  for (const double level : {0.01, 0.05})
    for (const int order : {8, 10, 12, 14, 16, 20})
      row("eight modes", level, order, simulated::eight_modes(), [&](unsigned seed) {
        return to_circle_form(with_noise_floor(simulated::eight_mode_set(level, seed)),
                              fem::Damping::structural);
      });
  for (const double spacing : {0.2, 0.3, 0.5, 0.7, 1.0, 2.0})
    for (const double level : {0.001, 0.01, 0.05}) {
      const auto modes = pair_of(spacing);
      row(fmt::format("pair {} bandwidths apart", spacing), level, 14, modes, [&](unsigned seed) {
        TransferFunction tf =
            simulated::function_of(modes, simulated::lines(100.0, 500.0, 0.5), FrfKind::receptance);
        simulated::add_noise(tf, {level, level, level}, seed);
        return tf;
      });
    }
}
