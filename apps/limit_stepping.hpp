#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// Newmark's kappa and lambda over steps per period: a clamped wire shaken from 10 to 300 Hz, force of its
/// supports (rms over rms) against exact modal stepping. Refused: NewmarkStepper does
/// not take the pair; the error is then what the same scheme without that refusal would have given. Flagged:
/// fem::newmark_error() above 5 %.
LimitMap newmark_parameter_limits(const LimitRun& run);

/// The same wire in its modes, those above a frequency left to statics, over the tolerance asked: the
/// middle's displacement (0) and the supports' force (1), largest error over largest value, against every
/// mode stepped. Refused: below static_mode_limit(), where `simulate` steps the modes; the error is what
/// leaving them out would have made.
LimitMap truncation_limits(const LimitRun& run);

}  // namespace struna::apps
