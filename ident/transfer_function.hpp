#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "ident/spectra.hpp"

namespace struna::ident {

/// What an output over an input is; travels with the data.
enum class FrfKind {
  dynamic_stiffness,  ///< force / displacement [N/m]
  impedance,          ///< force / velocity [N s/m]
  apparent_mass,      ///< force / acceleration [kg]
  receptance,         ///< displacement / force [m/N]
  mobility,           ///< velocity / force [m/s/N]
  accelerance,        ///< acceleration / force [m/s^2/N]
  transmissibility,   ///< like over like [1]
  unknown
};

std::string unit_of(FrfKind kind);              ///< "N/m", "kg", …; "" for unknown
FrfKind kind_of_unit(const std::string& unit);  ///< unknown when not listed
std::string to_string(FrfKind kind);            ///< "dynamic-stiffness", …
FrfKind frf_kind(const std::string& word);      ///< throws Error on another word
FrfKind kind_of(Quantity output, Quantity input);

/// The functions of one input to several outputs on common lines.
struct TransferFunction {
  struct Output {
    std::string name;
    FrfKind kind = FrfKind::unknown;
    std::string unit;  ///< as written in the file
    Eigen::VectorXcd value;
    Eigen::VectorXd coherence;  ///< empty when it cannot be known
    Eigen::VectorXd sigma;  ///< standard deviation of the real and of the imaginary part; empty when unknown
  };
  Eigen::VectorXd frequency_hz;
  std::vector<Output> outputs;
  double exponential_decay = 0.0;  ///< [1/s] an exponential window added to every mode; see Spectra
  double leakage_hz =
      std::numeric_limits<double>::quiet_NaN();  ///< line spacing of the Hann window that widens resonances
                                                 ///< as the estimator did; 0: it does not leak; NaN: unknown

  long lines() const { return frequency_hz.size(); }
};

/// Name, kind and unit of a channel over the input, without values.
TransferFunction::Output empty_output(const Channel& output, const Channel& input);

enum class Estimator { h1, h2, hv, amplitude_ratio };
Estimator estimator_kind(const std::string& word);  ///< throws Error on another word
std::string to_string(Estimator estimator);

/// H1 = S_xy/S_xx (noise on the output), H2 = S_yy/conj(S_xy) (noise on the input), Hv (both, total least
/// squares with each channel scaled by its own spectrum, so that units do not matter: it is the geometric
/// mean of H1 and H2); amplitude_ratio sqrt(S_yy/S_xx), real.
///
/// Coherence c in [0, 1]; sigma = |H| sqrt((1 - c)/(2 c (n - 1))) per real and imaginary part, n the
/// effective number of averages, for H1, H2, Hv alike, each with its own |H|: noise shifts all three alike to
/// first order (Bendat & Piersol, Random Data 4th ed., ch. 9; n - 1 instead of n since the scatter is taken
/// about the estimate itself). amplitude_ratio: |H| sqrt((1 - c)/(2 n)). Both are left out for a single
/// average.
///
/// Left out are the lines at 0 Hz (it went with the mean), at the Nyquist frequency (real by construction),
/// and those without power to divide by.
TransferFunction estimate_transfer_function(const Spectra& spectra, Estimator estimator);

/// Changes the motion quantity (powers of i omega; drops a line at 0 Hz where the division needs it).
/// Inverts, first order in sigma, where the wanted kind has force and motion swapped: only for one output,
/// which must be a drive point. Throws Error otherwise, or for unknown kinds and transmissibilities.
TransferFunction convert(const TransferFunction& tf, FrfKind kind);

/// Lines with lo <= f <= hi. Throws Error when none is left.
TransferFunction restrict_band(const TransferFunction& tf, double lo_hz, double hi_hz);

}  // namespace struna::ident
