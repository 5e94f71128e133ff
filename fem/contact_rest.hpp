#pragma once

#include <vector>

#include "fem/contact_solver.hpp"

namespace struna::fem {

/// Static equilibrium of points on springs: F = k g along h/|h| where g > 0, else none, h = h_free - W F n.
///
/// It is the minimum of the convex energy  f.W f/2 + sum k max(0, g)^2/2  over the force vectors f (dimension
/// components per point), so there is one answer whatever the gaps and however far the free offsets lie
/// beyond them. Newton with both parts of the force's slope, k [n n^T + (g/|h|)(1 - n n^T)] - the second
/// turns the force - and steps halved until the energy falls (Nocedal & Wright, Numerical Optimization, 2nd
/// ed., section 3.1).
///
/// `contacts`: all points that may close, end_offset free of contact; end_offset, end_penetration, force and
/// direction come back. `w`: flexibility between their components [m/N], symmetric, positive semidefinite.
/// False: not found (offsets that are not finite, or springs whose force is all rounding).
bool rest_in_contact(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w);

}  // namespace struna::fem
