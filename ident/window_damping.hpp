#pragma once

#include "ident/mode.hpp"

namespace struna::ident {

/// A pole of records under a window e^(-decay t), decay [1/s], without it: the window gives the function
/// along s = a + i omega, so every pole in omega stands i a above its place: omega_r sqrt(1 + i eta)
/// (hysteretic) or omega_r (sqrt(1 - zeta^2) + i zeta) (viscous). The loss factor left may be negative.
Pole without_window(const Pole& pole, double decay, fem::Damping damping);

/// Takes a window's damping out of all modes, their circles and the stabilisation analysis; modes and poles
/// left without damping are dropped, modes with the reason told.
void take_out_window_damping(double decay, fem::Damping damping, ModeSet& set);

}  // namespace struna::ident
