#pragma once

#include "ident/mode.hpp"

namespace struna::ident {

struct MultiModeOptions {
  fem::Damping damping = fem::Damping::structural;
  int max_iterations = 100;
  bool sigma_known =
      true;  ///< false: sigma gives weights only (it was estimated), the scatter gives the noise
};

/// All modes of a band together: common poles over all outputs, complex constants, and residual terms
/// (1/omega^2, 1, omega^2 in circle form) for what lies outside, by separable (variable projection) maximum
/// likelihood weighted by sigma; covariance out of the fit (fit_poles). Without sigma it is estimated from
/// the lines' own differences (noise_floor.hpp) and scaled by the scatter. `start` gives the poles
/// (frequency, loss factor); the result has as many modes, ascending, circles untouched.
struct MultiModeFit {
  std::vector<Mode> modes;
  Eigen::MatrixXcd fitted;    ///< lines x outputs, circle form
  double weighted_rms = 0.0;  ///< of (data - fit)/sigma per degree of freedom; 1 when the model holds
  bool converged = false;
};
MultiModeFit fit_multi_mode(const TransferFunction& circle_form_tf, const std::vector<Mode>& start,
                            const MultiModeOptions& options = {});

}  // namespace struna::ident
