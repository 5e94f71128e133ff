#pragma once

#include <Eigen/Core>
#include <vector>

namespace struna::ident {

/// Transfer functions under periodic excitation: the lines that it excites, without window or leakage.
struct PeriodicEstimate {
  Eigen::VectorXd frequency_hz;
  Eigen::MatrixXcd value;     ///< mean Y over mean X, lines x outputs
  Eigen::MatrixXd sigma;      ///< of the real and of the imaginary part; from the scatter over periods
  Eigen::MatrixXd coherence;  ///< |H|^2 |X|^2/(|H|^2 |X|^2 + S_nn), S_nn the scatter of one period
  long periods = 0;           ///< used
  long settling = 0;          ///< left out at the beginnings
};

/// Averages whole periods of records of one setup (samples by channels, the input first), the last ones of
/// each. Periods at a record's beginning that differ from the last by more than four times what the last but
/// one does, in any output's power, are left out as settling, as long as two remain. Lines whose input power
/// is not thirty times what noise, their own or that of most lines, leaves in its mean are not excited and
/// left out. Needs two periods in each record. Pintelon & Schoukens, System Identification, 2nd ed.,
/// section 2.5 (errors-in-variables mean).
PeriodicEstimate periodic_estimate(const std::vector<Eigen::MatrixXd>& records, long period,
                                   double sample_interval);

}  // namespace struna::ident
