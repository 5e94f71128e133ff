#pragma once

#include "ident/mode.hpp"

namespace struna::ident {

/// How much wider than it is a resonance is seen through a Hann window, relative, from the half-power band
/// that is seen: rough excitation averages H over the window's power, which has a variance of a third of a
/// line spacing squared, so that with n spacings in the true band peak and arc widen by 4/3 n^-2 to first
/// order, evenly weighted lines up to 1.5 n^-2. Averages leak where their sigma is large, and fits that weigh
/// them by it see 0.2 to 0.8 n^-2 (docs/transfer_function.md): leakage_share n^-2 is what is taken out. 1
/// where no resonance, however narrow, would be seen narrower; 0 for leakage_hz 0 or NaN (see
/// TransferFunction).
double leakage_widening(double seen_half_power_band_hz, double leakage_hz);
inline constexpr double leakage_share = 0.7;

/// By how much such a window lowers |H| at that resonance's peak, relative: x/(1 + 2 x),
/// x = 4/3 n^-2, which keeps to a few hundredths of the peak as computed (docs/transfer_function.md).
double leakage_lowering(double seen_half_power_band_hz, double leakage_hz);

/// Of that widening, what may be left in a loss factor after it was taken out.
inline constexpr double leakage_doubt = 0.6;

/// Takes the widening out of a mode's loss factor and half-power band, and adds leakage_doubt of it to the
/// standard error. Nothing where the leakage is unknown.
void take_out_leakage(Mode& mode, double leakage_hz, fem::Damping damping);

}  // namespace struna::ident
