#pragma once

#include "ident/mode.hpp"

namespace struna::ident {

/// Peak picking: resonance at the top of the summed squared magnitude (parabola through its lines),
/// half-power frequencies where it has fallen to a half (interpolated), eq. (13). The crudest method; no
/// residuals, no standard errors. `tf` in circle form.
Mode fit_half_power(const TransferFunction& circle_form_tf, double start_hz, double lo_hz, double hi_hz,
                    fem::Damping damping);

}  // namespace struna::ident
