#pragma once

#include "apps/limit_map.hpp"

namespace struna::apps {

/// A contact's spring for a wall: a wire in a stiff tube, shaken at random, against the hard stop of the same
/// restitution: rms and peak of the displacement of the wire's middle relative to its supports over half a
/// second. Axes: the spring over the stiffness of a node between its neighbours, acceleration, damping ratio
/// of a blow. Flagged: the warnings that the spring is too soft to stand for a wall.
LimitMap penalty_limits(const LimitRun& run);

}  // namespace struna::apps
