#pragma once

#include <vector>

#include "ident/mode.hpp"

namespace struna::ident {

/// What the poles' fit together says of their circles. A circle looks a bandwidth to either side, and a
/// neighbour's tail or a second mode hides there as a bent arc. So all poles are fitted together (fit_band,
/// five bandwidths either side, none added), and each circle is compared with its own there; its values stay.
///
/// Standard errors: at least the root of (distance of the two)^2 + (standard error of the fit together)^2, an
/// estimate of the circle's mean square error, the neighbours' part included.
/// Flags: double_mode, may_be_two and resolves_from of the fit together; close_modes where frequency or loss
/// factor part by more than 1 % (of bandwidth, of loss factor) and one chance in 2000 for noise. Without
/// neighbours the variance of the distance is the difference of the variances (Hausman, Econometrica 46
/// (1978) 1251). close_modes too where the pole found no support beside the others.
/// `circle_form_tf` with sigma; `circles` of fit_circle.
void judge_circles(const TransferFunction& circle_form_tf, fem::Damping damping, bool sigma_known,
                   std::vector<Mode>& circles);

}  // namespace struna::ident
