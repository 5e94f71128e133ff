#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "apps/tradeoff_chart.hpp"
#include "apps/usage.hpp"
#include "fem/harmonic.hpp"
#include "fem/scene.hpp"
#include "fem/sizing.hpp"

namespace struna::apps {

/// A body, what shakes it and what is read, over a band: what the stages `model` and `harmonic` work on.
struct LinearProblem {
  std::string name;
  fem::Body body;
  fem::Drive drive;
  fem::Measurement measurement;
  fem::Damping damping = fem::Damping::structural;
  Band band{10.0, 1000.0};
};

/// Clamped steel-like wires of 0.68 m and 3.2 mm, eta = 0.02, one clamp shaken, the force at the other read:
/// straight, and along a spline with inflections.
LinearProblem straight_wire_problem();
LinearProblem spline_wire_problem();
/// What a scene drives and measures, in the damping that acts. Throws Error when that is not one body.
LinearProblem scene_problem(const fem::Scene& scene, const std::string& name, const Band& band);

/// The solution of a problem to far more digits than any mesh on a chart has.
///
/// The element's error falls as h^4, so that (16 fine - coarse)/15 of two meshes, the finer one of twice the
/// default elements, cancels it (Richardson). The error that is left is estimated from the same on meshes
/// half as fine: what the two differ by, over 16 (it falls as h^6 or faster).
struct LinearReference {
  Eigen::VectorXd natural_frequency_hz;  ///< up to the band's end
  Eigen::VectorXd line_hz;
  Eigen::MatrixXcd response;  ///< lines x outputs
  double frequency_error = 0.0;
  double response_error = 0.0;
  std::string text;
};
/// `lines`: how many, evenly over the band.
LinearReference linear_reference(const LinearProblem& problem, long lines);
/// The same without natural frequencies, which take longer than all lines.
LinearReference response_reference(const LinearProblem& problem, long lines);

/// Elements that the program takes for natural frequencies or for a response: the body's own, or those of the
/// automatic choice.
int default_elements(const LinearProblem& problem, fem::SizingTarget target);

/// Largest |f/f_ref - 1| over the reference's modes; infinite when there are fewer.
double frequency_error(const Eigen::VectorXd& natural_frequency_hz, const Eigen::VectorXd& reference);

/// |H - H_ref| over |H_ref|, rms over the lines, of the worst output; outputs that are zero but for rounding
/// (below 1e-6 of the largest) are left out.
double response_error(const Eigen::MatrixXcd& response, const Eigen::MatrixXcd& reference);

}  // namespace struna::apps
