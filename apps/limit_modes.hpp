#pragma once

#include "apps/limit_map.hpp"
#include "ident/mode.hpp"
#include "ident/pole_fit.hpp"

namespace struna::apps {

/// The mode found next to a true one, within its half-power bandwidth; null: none.
const ident::Mode* mode_near(const std::vector<ident::Mode>& found, const ident::Pole& truth);
/// Error, standard error, tolerance and flags of a mode: of natural frequency (over the true bandwidth) or
/// loss factor (relative) the one that is farther off in units of its standard error. Tolerances: 1 % of
/// each. Without the flag may_be_two, which only speaks of a second mode.
void judge_mode(const ident::Mode& mode, const ident::Pole& truth, LimitTrial& trial);

/// Two modes side by side (200 Hz, loss factor 0.02, two outputs in which their shapes differ) among two
/// distant ones, over their spacing, noise and lines per half-power bandwidth. A trial for each of the two:
/// the worse of natural frequency (in bandwidths) and loss factor (relative), in units of the standard
/// error stated. A mode that is not found is judged by the mode within a bandwidth that stands for it, and
/// counts as refused where there is none.
LimitMap circle_limits(const LimitRun& run);      ///< --method circle
LimitMap multi_mode_limits(const LimitRun& run);  ///< --method auto

}  // namespace struna::apps
