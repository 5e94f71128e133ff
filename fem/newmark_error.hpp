#pragma once

#include "fem/material.hpp"
#include "fem/newmark.hpp"

namespace struna::fem {

/// Relative rms error that the scheme leaves, without contact, in the force that a motion up to `highest_hz`
/// moves a body with over `duration` [s]. It shifts a vibration's pole (constant average acceleration: too
/// slow by (w dt)^2/12, Bathe, section 9.4; lambda > 1/2: damped), and that adds up while it rings, by as
/// much as this motion happens to excite it. So the modes up to twice the motion's highest frequency, no
/// fewer than three, are stepped by the scheme (Rayleigh damping leaves them uncoupled) and exactly; what the
/// higher ones add to the force follows statically. `modes`: viscous, with `rayleigh`; where nothing drives
/// them the error is 0. Throws Error as the steppers do.
double newmark_error(const NewmarkOptions& options, const ModalBody& modes, const Rayleigh& rayleigh,
                     const PrescribedMotion& motion, double highest_hz, double duration);

}  // namespace struna::fem
