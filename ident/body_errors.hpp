#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem/body_number.hpp"
#include "ident/law_fit.hpp"

namespace struna::ident {

/// Steps of one standard error each, independent of each other, that make up a covariance (its eigenvectors,
/// of unit diagonal first: the parameters' units are worlds apart). None where it is empty or not finite.
std::vector<Eigen::VectorXd> independent_steps(const Eigen::MatrixXd& covariance);

/// Measured frequencies and the model modes that they stand for.
struct PairedFrequency {
  double frequency_hz = 0.0;
  std::vector<int> mode;  ///< places among the eigenmodes at hand; several: their mean counts
  double sigma = 0.0;     ///< relative, of the modulus read off it
};

/// Mean of a quantity of the modes over the members of each pair.
Eigen::VectorXd over_pairs(const std::vector<PairedFrequency>& pairs, const Eigen::VectorXd& of_modes);

/// Numbers of the body that were fitted beside the modulus law, out of the same frequencies.
struct FittedNumbers {
  std::vector<std::string> name;
  Eigen::VectorXd value;       ///< springs: at the modulus of fem::support_reference_hz
  Eigen::MatrixXd covariance;  ///< relative for springs and the torsion constant (of their logarithms), of
                               ///< the value for masses
  double condition = 0.0;      ///< of the joint fit, its columns of unit length; 0 without one
  struct Inseparable {
    std::string name;
    std::string reason;
  };
  std::vector<Inseparable> inseparable;  ///< asked for, and left as the scene has them

  Eigen::VectorXd sigma() const;  ///< of the values
};

/// Whether the number's error is told relative to it: all but masses.
bool is_relative(const std::string& fitted_number);

/// One independent error of one standard deviation in what the body is taken to be, and all that follows from
/// it: the modulus read off the same frequencies moves too.
struct BodyErrorStep {
  std::string of;      ///< the number that the scene states, "fitted" for a direction of the fitted ones
  double value = 0.0;  ///< of that number, as stated; 0 for fitted ones
  double sigma = 0.0;
  std::vector<std::string> number;  ///< what moves in the body: the number itself, and fitted ones with it
  std::vector<double> change;
  double level = 0.0;        ///< relative change of the modulus law, mean over the modes
  Eigen::VectorXd modulus;   ///< relative change of E at each mode
  Eigen::VectorXd law_step;  ///< change of the law's numbers

  bool is_fitted() const { return of == "fitted"; }
};

/// To first order: lambda changes by the slopes a of the number, so ln E at the modes by -a, and law (and
/// fitted numbers) as their weighted least squares follow (docs/body_errors.md). `modes` are those of
/// `model`, the body with its fitted numbers; `law` what was fitted to the moduli of `pairs`. One step per
/// stated number with a sigma, then those of the fitted numbers.
std::vector<BodyErrorStep> body_error_steps(const fem::Model& model, const fem::Eigenmodes& modes,
                                            const std::vector<PairedFrequency>& pairs, const LawFit& law,
                                            const FittedNumbers& fitted);

/// Relative standard deviation of the moduli at the modes by the steps that are (or are not) fitted ones'.
Eigen::VectorXd common_modulus_sigma(const std::vector<BodyErrorStep>& steps, bool fitted);

/// Standard deviation of the law's value at f by the same.
double law_sigma(const fem::FrequencyLaw& law, const std::vector<BodyErrorStep>& steps, bool fitted,
                 double f_hz);

}  // namespace struna::ident
