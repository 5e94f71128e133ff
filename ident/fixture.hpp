#pragma once

#include <map>
#include <string>

#include "ident/transfer_function.hpp"

namespace struna::ident {

/// What the fixture between force cell and wire adds to the measured force: the clamp's mass, or all that an
/// empty run (everything but the wire) shows. Both hold for force over motion, read where the motion is or on
/// a common frame.

/// Takes out masses [kg] that move with the input, by output: F/u + omega^2 m, impedance Z - i omega m,
/// apparent mass less m. Throws Error for an output that is not there or is no force over motion, and for a
/// mass that is negative or not finite.
TransferFunction without_mass(TransferFunction function, const std::map<std::string, double>& mass);

/// Takes out what an empty run shows, output by output, its lines interpolated linearly (a fixture is
/// smooth), its sigma added. Outputs that it lacks stay as they are. Throws Error where it has no line on
/// both sides of one of the function's, none of its outputs, or another quantity than force over motion.
TransferFunction without_fixture(TransferFunction function, const TransferFunction& empty);

}  // namespace struna::ident
