#pragma once

#include <string>
#include <vector>

#include "ident/body_errors.hpp"

namespace struna::ident {

/// The body to begin with: supports that are to be fitted and do not give yet, given springs of a compliance
/// EI/(kL), EI/(kL^3). Throws Error where a number cannot be fitted, is named twice, or "both" beside one of
/// its ends.
fem::Body with_finite_supports(fem::Body body, const std::vector<std::string>& names, double compliance);

/// Throws Error on a law that follows whatever the numbers do: all but constant and power.
void check_joint_law(fem::FrequencyLaw::Kind law);

struct JointFit {
  fem::Body body;  ///< with the fitted numbers; the model's own where one was inseparable
  FittedNumbers fitted;
  double chi_square = 0.0;  ///< of the frequencies
};

/// Numbers of the body together with a modulus law (constant or power), from the paired frequencies: least
/// squares (Ceres) of (ln omega_i^2 - ln lambda_i(numbers) - ln law(f_i))/sigma_i, the eigenproblem solved at
/// every step and its modes followed by their shapes. Supports in terms of their compliance, from rigid on;
/// masses not negative; the torsion constant by its logarithm (docs/joint_fit.md).
///
/// Where the frequencies do not tell a number, alone or from the law and the others, the worst such is named
/// with the reason in `inseparable`, and nothing is fitted: without it the others may be told. `model` is a
/// mesh of with_finite_supports(); `modes` the elastic ones that the pairs count, `rigid` how many came
/// before them. Throws Error on another law.
JointFit fit_body_numbers(const fem::Model& model, const fem::Eigenmodes& modes, int rigid,
                          const std::vector<PairedFrequency>& pairs, fem::FrequencyLaw::Kind law,
                          const std::vector<std::string>& names);

}  // namespace struna::ident
