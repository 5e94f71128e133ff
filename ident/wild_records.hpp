#pragma once

#include <random>
#include <string>
#include <vector>

#include "ident/transfer_estimate.hpp"

namespace struna::ident {

struct WildOptions {
  long blocks = 40;  ///< over all records, where these are not parted by themselves: five records or more,
                     ///< and hits, are one block each, periodic records have one per period
};

/// Records that the same experiment could have given, as far as its own scatter tells: the wild bootstrap by
/// blocks (Liu, Ann. Statist. 16 (1988) 1696; by clusters: Cameron, Gelbach & Miller, Rev. Econ. Stat. 90
/// (2008) 414). The output less what the estimated function makes of the input is cut into blocks of time,
/// each is multiplied by a random sign, and added to what the function makes. Nothing is assumed of the
/// noise but that blocks are independent: it may swell and fade, follow the input, or be a structure that
/// drifts; the standard errors that an estimator states assume it steady and unrelated to the input.
class WildRecords {
 public:
  /// `records` of one setup, `estimate` of their transfer functions over all lines, in the form measured.
  /// Throws Error for fewer than five blocks: their signs could not tell a scatter.
  WildRecords(const std::vector<Record>& records, const std::string& input,
              const std::vector<std::string>& outputs, const TransferEstimate& estimate, bool impact,
              const WildOptions& options = {});

  long blocks() const { return blocks_; }
  std::vector<Record> draw(std::mt19937_64& random) const;

 private:
  struct Part {
    Record made;               ///< input, and what the function makes of it
    Eigen::MatrixXd residual;  ///< samples x outputs
    long block = 0;            ///< samples
  };
  std::vector<Part> parts_;
  long blocks_ = 0;
};

/// A function at frequencies between its lines: of the rational function of degrees (1, 1) through three
/// lines, which is exact for one resonance beside a constant, the two about the gap, blended; straight where
/// these have a pole nearby. Beyond its ends the end's value.
Eigen::VectorXcd between_lines(const Eigen::VectorXd& line_hz, const Eigen::VectorXcd& value,
                               const Eigen::VectorXd& f_hz);

}  // namespace struna::ident
