#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// A wire rattling in a band under a sine whose frequency and size the seed draws, over the fixed step, the
/// contact's stiffness and its dashpot: largest error of the contact points' distances over the largest one,
/// up to where the program says that it has checked (20 ms beyond the first touch), against the modal method
/// at a tolerance of 1e-5, as far as that and one at 1e-4 stay together. Flagged: the warning that the step
/// is too long for the contacts. A step at which contact forces are not found is refused. The modal method
/// takes contact_substeps = 1: the step in contact is the one given.
LimitMap newmark_contact_limits(const LimitRun& run);
LimitMap modal_contact_limits(const LimitRun& run);

/// The same wire by the modal method to a tolerance, against one of 1e-6 as far as that and 1e-5 stay
/// together. Flagged: the warning that the tolerance is not met.
LimitMap contact_tolerance_limits(const LimitRun& run);

}  // namespace struna::apps
