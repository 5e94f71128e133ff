#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// The shaken wire's third mode from records, over independent lines in its half-power band (1/(length of a
/// segment or record) apart) and noise of the force: the worse of natural frequency and loss factor of the
/// default multi-mode fit. Flagged: flags of the mode, and the warning that leakage or few lines leave its
/// damping open.
LimitMap leakage_limits(const LimitRun& run);      ///< Welch, Hann window, H1; 7.5 segments long
LimitMap local_model_limits(const LimitRun& run);  ///< what `auto` takes for steady noise

/// The same records as in leakage_limits: the function itself at its peak. Flagged: the warning that leakage
/// lowers it.
LimitMap leakage_peak_limits(const LimitRun& run);

}  // namespace struna::apps
