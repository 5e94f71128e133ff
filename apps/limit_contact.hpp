#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// A wire rattling in a band under a sine whose frequency and size the seed draws, over the fixed step, the
/// contact's stiffness and its dashpot: largest error of the contact points' distances over the largest one,
/// up to where the program says that it has checked (20 ms beyond the first touch), against the modal method
/// at tolerances of 1e-5 and 1e-6, whichever is farther: where these part, nobody knows the path. Flagged:
/// the warning that the step is too long for the contacts, or for their blows. A step at which contact forces
/// are not found is refused. The modal method takes contact_substeps = 1: the step in contact is the one
/// given.
LimitMap newmark_contact_limits(const LimitRun& run);
LimitMap modal_contact_limits(const LimitRun& run);

/// The same wire by the modal method to a tolerance, against tolerances of 1e-7 and 1e-8. Flagged: the
/// warning that the tolerance is not met.
LimitMap contact_tolerance_limits(const LimitRun& run);

/// The same wire in ever stiffer bands, over tolerance or step and method, against tolerances of 1e-6 and
/// 1e-7. Wrong is also a run of more than a million steps, in 30 ms. Refused: stiffer than steps could
/// follow; the error is then what the modal stepper without that refusal would have made, infinite where it
/// fails or takes more steps than that.
LimitMap stiff_wall_limits(const LimitRun& run);

}  // namespace struna::apps
