#pragma once

#include "ident/transfer_function.hpp"

namespace struna::ident {

/// How the lines of a dynamic stiffness D are weighed in fit_single_dof_stiffness.
enum class StiffnessWeight {
  sigma,       ///< 1/sigma: what averaging says about each line
  relative,    ///< 1/|D|: an error in proportion to D. What makes H (k - m omega^2 + i omega c) = 1 linear in
               ///< k, m, c
  integrated,  ///< 1/(omega^2 |D|): the relative error grows as omega^2, as it does where displacement,
               ///< falling as 1/omega^2, meets its noise floor; the equation of motion integrated twice in
               ///< time
};

/// k - m omega^2 + i omega c with its standard errors.
struct SingleDof {
  double stiffness = 0.0;  ///< k [N/m]
  double mass = 0.0;       ///< m [kg]
  double damping = 0.0;    ///< c [N s/m]
  double stiffness_sigma = 0.0;
  double mass_sigma = 0.0;
  double damping_sigma = 0.0;
  double natural_frequency_hz = 0.0;  ///< sqrt(k/m)/(2 pi); NaN unless k and m are positive
  double damping_ratio = 0.0;         ///< c/(2 sqrt(k m)); likewise
  double scatter = 0.0;               ///< weighted rms of what is left, over the weighted rms of D

  bool physical() const { return stiffness > 0.0 && mass > 0.0; }
};

/// Spring, mass and dashpot by linear least squares of k - m omega^2 + i omega c over all lines: k and m from
/// the real part, c from the imaginary part. Standard errors from the scatter left over (from sigma where it
/// weighs). An exponential window's decay a is taken into account: the function is k + s^2 m + s c at s = a +
/// i omega. `tf`: one output whose kind is dynamic stiffness, at least 3 lines. Throws Error otherwise, or
/// when sigma is asked for and unknown.
SingleDof fit_single_dof_stiffness(const TransferFunction& tf,
                                   StiffnessWeight weight = StiffnessWeight::relative);

}  // namespace struna::ident
