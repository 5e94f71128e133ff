#pragma once

#include <string>
#include <vector>

#include "ident/mode.hpp"

namespace struna::ident {

/// One quantity of a mode, found several times with standard errors, in the random-effects model
/// x_k = mean + b_k + e_k: e_k are the stated errors, b_k what besides changes from set to set.
struct Variation {
  double mean = 0.0;         ///< weighted by 1/(sigma_k^2 + between^2)
  double mean_sigma = 0.0;   ///< its standard error, with what changes
  double between = 0.0;      ///< standard deviation of b, 0 where the stated errors explain the scatter
  double largest = 0.0;      ///< largest difference of two sets
  double probability = 1.0;  ///< of at least this scatter from the stated errors alone
  bool exceeds_errors() const { return probability < 0.05; }
};

/// `value` and `sigma` of each set, at least one. DerSimonian & Laird, Controlled Clinical Trials 7 (1986)
/// 177. Throws Error for a sigma that is not positive.
Variation variation_of(const Eigen::VectorXd& value, const Eigen::VectorXd& sigma);

/// A mode that stands in one or more sets.
struct ModeVariation {
  std::vector<long> place;      ///< in each set; -1: not there
  Variation frequency;          ///< natural frequency [Hz]
  Variation damping;            ///< loss factor; damping ratio where the sets are viscous
  std::vector<ModeFlag> flags;  ///< those of any set
  long sets() const;            ///< that have it
};

/// Modes of the same structure, identified apart (another hit, another day, another clamping), set against
/// each other: those nearest to each other in frequency, within a half-power bandwidth or five standard
/// errors, are one mode. Ascending in frequency. Throws Error for fewer than two sets, sets of different
/// damping models, a set without modes or modes without standard errors.
std::vector<ModeVariation> mode_variation(const std::vector<ModeSet>& sets);

/// variation.csv: natural_frequency [Hz],natural_frequency_sigma [Hz],natural_frequency_between [Hz],
/// natural_frequency_largest [Hz],natural_frequency_probability [-], the same five of loss_factor (viscous:
/// damping_ratio) [-],sets [-],flags. Atomic.
void write_mode_variation(const std::vector<ModeVariation>& modes, fem::Damping damping,
                          const std::string& file);

}  // namespace struna::ident
