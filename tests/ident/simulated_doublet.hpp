#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "ident/mode_identification.hpp"
#include "ident/pole_fit.hpp"
#include "simulated_modes.hpp"

/// A pair of modes of equal height: what becomes of it?
namespace struna::ident::simulated {

struct Doublet {
  double spacing = 1.0;  ///< half-power bandwidths
  int outputs = 3;       ///< 1 or 3
  double noise = 0.01;   ///< of a peak's height, in the real and in the imaginary part
};

struct Verdicts {
  unsigned resolved = 0;  ///< two modes within their error bars
  unsigned flagged = 0;   ///< no such two, but every mode near says that it is not to be trusted
  unsigned wrong = 0;     ///< silently
};

inline std::vector<SimulatedMode> modes_of(const Doublet& doublet) {
  constexpr double eta = 0.02;
  const double shape[2][3] = {{1.0, 0.3, -0.5}, {1.0, -0.6, 0.4}};
  std::vector<SimulatedMode> modes;
  for (int r = 0; r < 2; ++r) {
    SimulatedMode mode{{100.0 + r * doublet.spacing * eta * 100.0, eta}, {}};
    for (int k = 0; k < doublet.outputs; ++k)
      mode.constant.push_back(shape[r][k] * pole_scale(mode.pole, fem::Damping::structural));
    modes.push_back(mode);
  }
  return modes;
}

inline TransferFunction function_of(const Doublet& doublet) {
  return function_of(modes_of(doublet), lines(80.0, 130.0, 0.1), FrfKind::receptance);
}

/// Five standard errors: beyond that no honest error bar.
inline bool within_bars(const Mode& mode, const Pole& truth) {
  return std::abs(mode.natural_frequency_hz - truth.natural_frequency_hz) <
             5.0 * mode.natural_frequency_sigma &&
         std::abs(mode.loss_factor - truth.loss_factor) < 5.0 * mode.loss_factor_sigma;
}

inline Verdicts doublet_verdicts(const Doublet& doublet, unsigned seeds) {
  const std::vector<SimulatedMode> truth = modes_of(doublet);
  const TransferFunction clean = function_of(doublet);
  Verdicts verdicts;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    TransferFunction tf = clean;
    add_noise(tf, std::vector<double>(static_cast<std::size_t>(doublet.outputs), doublet.noise), seed);
    const ModeSet set = identify_modes(tf);
    const bool resolved = set.modes.size() == 2 && within_bars(set.modes[0], truth[0].pole) &&
                          within_bars(set.modes[1], truth[1].pole);
    const bool flagged =
        !set.modes.empty() &&
        std::none_of(set.modes.begin(), set.modes.end(), [](const Mode& mode) { return mode.flags.empty(); });
    ++(resolved ? verdicts.resolved : flagged ? verdicts.flagged : verdicts.wrong);
  }
  return verdicts;
}

}  // namespace struna::ident::simulated
