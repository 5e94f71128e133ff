#pragma once

#include <string>
#include <vector>

#include "ident/transfer_function.hpp"

namespace struna::ident {

struct PeakDifference {
  double measured_hz = 0.0;
  double predicted_hz = 0.0;
  double amplitude_db = 0.0;  ///< 20 lg(|H_p|/|H_m|) at their peaks
};
struct OutputComparison {
  std::string output;
  double frac = 0.0;                    ///< |H_p^H H_m|^2/((H_m^H H_m)(H_p^H H_p)), Heylen, Lammens & Sas
  double log_magnitude_error_db = 0.0;  ///< rms of 20 lg|H_p/H_m| over the band
  double mean_db = 0.0;                 ///< mean of the same: a level offset
  double largest_db = 0.0;              ///< largest magnitude of the same
  std::vector<PeakDifference> peaks;    ///< peaks of the measured one, each with the predicted one nearest to it
};
struct Comparison {
  double lo_hz = 0.0;
  double hi_hz = 0.0;
  std::vector<OutputComparison> outputs;
};

/// Compares outputs of the same name and kind over the band that both have (prediction interpolated to the measured lines when they
/// differ, in magnitude and phase between neighbouring lines). Throws Error when no output or line is common.
Comparison compare(const TransferFunction& measured, const TransferFunction& predicted, double lo_hz = 0.0,
                   double hi_hz = 0.0);
void write_comparison(const Comparison& comparison, const std::string& file);

}  // namespace struna::ident
