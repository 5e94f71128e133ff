#pragma once

#include <vector>

#include "ident/mode.hpp"
#include "ident/references.hpp"

namespace struna::ident {

struct ReferenceModesOptions {
  fem::Damping damping = fem::Damping::structural;
  bool sigma_known = true;
};

/// The modes of several references (fit_band's, whose constants are free) with constants of rank one per
/// pole, group by group in the same windows (fit_rank_one). What several references say beyond one:
///   split   a pole whose constants have rank two (rank_excess beyond what noise makes) into two of rank one,
///           where that takes more from the sum of squares than Schwarz's (2 + 2 outputs + 2 (references -
///           1)) ln(data), times scatter and line correlation, both have support (modal constants of six
///           standard errors, 1e-5 < eta < 0.5), and their shapes differ (assurance of the outputs below
///           0.98, or one output): with one shape they may be one mode whose frequency moved from reference
///           to reference;
///   join    two poles within 0.3 bandwidths where one explains the lines as well by the same measure;
///   flag    double_mode, where a pole's constants are still not of rank one: two modes that the data do not
///           part, or a set-up that changed between the references. The flag is taken from modes whose
///           constants are.
/// `tf` in circle form with sigma; `modes` ascending, with constants. Needs at least two references.
std::vector<Mode> refine_with_references(const TransferFunction& tf, const References& references,
                                         const std::vector<Mode>& modes,
                                         const ReferenceModesOptions& options);

}  // namespace struna::ident
