#pragma once

#include <string>
#include <vector>

#include "ident/mode.hpp"

namespace struna::ident {

/// How a mode scatters over bootstrap replicates, against what its fit states.
struct ModeScatter {
  double natural_frequency_sd = 0.0;  ///< [Hz]; NaN where the mode was found in fewer than two replicates
  double loss_factor_sd = 0.0;
  long found = 0;                ///< replicates that have the mode
  double frequency_ratio = 0.0;  ///< natural_frequency_sd over the stated sigma
  double loss_factor_ratio = 0.0;
  bool doubtful = false;  ///< a ratio above what replicates and blocks allow, or seldom found
};

struct BootstrapScatter {
  std::vector<ModeScatter> modes;  ///< as the nominal set's
  long replicates = 0;
  double frequency_ratio = 0.0;  ///< root mean square over the modes found in all
  double loss_factor_ratio = 0.0;
  double ratio_sigma =
      0.0;  ///< standard error of one mode's ratio: sqrt(1/(2 (replicates - 1)) + 1/(2 blocks))
};

/// Scatter of each nominal mode over the replicates' nearest modes within half a bandwidth. Doubtful are
/// ratios above 1 + 3.5 ratio_sigma, and modes that less than nine replicates of ten have; ratios below 1 are
/// not, as stated errors hold what does not scatter too (the model's own error). Throws Error for fewer than
/// ten replicates.
BootstrapScatter bootstrap_scatter(const ModeSet& nominal, const std::vector<ModeSet>& replicates,
                                   long blocks);

/// CSV: mode, natural_frequency [Hz], its sigma, its bootstrap standard deviation, their ratio, the same of
/// the loss factor, found [-], doubtful [-]. Atomic.
void write_bootstrap(const ModeSet& nominal, const BootstrapScatter& scatter, const std::string& file);

}  // namespace struna::ident
