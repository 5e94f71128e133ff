#pragma once

#include <vector>

#include "ident/line_band.hpp"
#include "ident/mode.hpp"
#include "ident/resonance.hpp"

namespace struna::ident {

/// Times a band's end: farther out a pole is a trend, no neighbour.
inline constexpr double beyond_band = 1.3;

/// Modes that are fitted together, and where.
struct ModeGroup {
  std::vector<Pole> target;
  std::vector<Pole> company;  ///< neighbours in the window: fitted too, judged elsewhere
  std::vector<Mode> outside;  ///< all others: their shares are taken off beforehand
  Span window;                ///< lines of the fit
  Span territory;             ///< where its poles may be; past the band's end as background
  std::size_t first = 0;      ///< the targets are modes [first, last) of all
  std::size_t last = 0;
};

/// Modes nearer than four bandwidths form a group, of at most six; its window reaches 15 bandwidths (an
/// octave at most) either side and 15 lines at least, farther where it would end within three bandwidths of a
/// neighbour. Spans of the band that no window covers are groups without modes: a mode may hide there.
/// `modes` ascending in frequency.
std::vector<ModeGroup> group_modes(const std::vector<Mode>& modes, const LineBand& band);

/// The group with a window of so many bandwidths in place of 15: for structures that follow the model only
/// near resonance.
ModeGroup with_window(const ModeGroup& group, const std::vector<Mode>& modes, const LineBand& band,
                      double bandwidths);

/// The window's lines without what the modes outside send into it, sigma not below 3e-4 of the largest
/// magnitude: no structure follows the model closer, and where noise is (nearly) absent the antiresonances,
/// where the model's own error is large against the function, would else rule the fit.
TransferFunction lines_of(const TransferFunction& tf, const ModeGroup& group, fem::Damping damping);

Pole pole_of(const Mode& mode);
void sort_by_frequency(std::vector<Mode>& modes);

}  // namespace struna::ident
