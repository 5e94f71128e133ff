#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Rayleigh's two coefficients from some of ten modes (20 to 800 Hz) whose damping follows them but for a
/// constant part; over the number of modes, that part's share, and the standard error of a damping ratio.
/// Error: damping ratio at the worst, in standard errors, of five frequencies from 20 to 800 Hz.
LimitMap rayleigh_limits(const LimitRun& run);

/// E(f) fitted to eight moduli between 50 and 500 Hz, told at other frequencies; over the frequency, the
/// material's rise from rest to fast (a fractional Zener solid), and its relaxation frequency.
LimitMap extrapolation_limits(const LimitRun& run);

}  // namespace struna::apps
