#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/pairing.hpp"

namespace struna::ident {

/// A measured mode as the pairing sees it.
struct Candidate {
  double ln_f = 0.0;
  double loss_factor = 0.0;   ///< 0 where not known
  Eigen::VectorXcd constant;  ///< C of C/(omega_r^2(1 + i eta) - omega^2); empty where not known
  double noise = 0.0;         ///< relative variance of the constants
  double ln_f_sigma = 0.0;    ///< standard error of ln_f; 0 where not known
  double price_alone = 0.0;   ///< of leaving it unpaired
};

/// What one pole can stand for: a model mode, or nearly double ones together.
struct Explanation {
  std::vector<int> model;
  double eigenvalue =
      0.0;  ///< where the one pole lies: the members' mean, weighted by their share of the sum
  double ln_eigenvalue = 0.0;
  double spread = 0.0;   ///< of the members' eigenvalues, relative
  double spacing = 0.0;  ///< relative frequency step between the two units; 0 for one
  int first_unit = 0;
  int second_unit = -1;      ///< -1: one unit only
  Eigen::VectorXd constant;  ///< at E = 1 Pa, sum over the members
};

/// The cost of explaining the measured modes by the model's, for a coarse law E = E0 (f/f0)^n
/// (docs/pairing.md).
class PairingCost {
 public:
  PairingCost(const ModeSet& measured, const ModelModes& model, const PairingOptions& options);

  struct Law {
    double ln_modulus = 0.0;  ///< at the reference frequency
    double slope = 0.0;
    bool reversed = false;  ///< measured constants taken with the opposite sign
  };
  struct Assignment {
    double cost = 0.0;
    std::vector<int> explanation;  ///< per measured mode; -1: unpaired
  };
  /// The cheapest assignment. `tolerance` is the relative frequency misfit that counts little. A forbidden
  /// entry (measured mode, all explanations sharing a unit with this one) asks what else would do.
  Assignment assign(const Law& law, double tolerance, int forbidden_measured = -1,
                    int forbidden_explanation = -1) const;

  double reference_ln_f() const { return reference_ln_f_; }
  double expected_slope() const { return expected_slope_; }
  double ln_band() const { return band_hi_ - band_lo_; }  ///< of the upper end over the lower one
  bool has_constants() const { return has_constants_; }
  bool amplitude_known() const { return amplitude_known_; }
  const std::vector<Candidate>& candidates() const { return candidates_; }
  const Explanation& explanation(int index) const { return explanations_[static_cast<std::size_t>(index)]; }
  /// ln f at which the law puts an eigenvalue: (2 pi f)^2 = E(f) lambda.
  double ln_frequency(const Law& law, double ln_eigenvalue) const;
  /// Correlation of the constants' real part, and ln of the ratio of their lengths, measured over model; 0
  /// and infinite where the model's vanish. Only where the measured mode has constants.
  double correlation(const Candidate& measured, const Explanation& explanation, const Law& law) const;
  double ln_strength_ratio(const Candidate& measured, const Explanation& explanation, const Law& law) const;
  /// How many modes should have been seen, were the law true, that no explanation uses: each counts by the
  /// share that its peak has of what is seen there.
  double unseen(const Law& law, const std::vector<int>& used) const;
  /// |sum conj(C) c|^2/(|C|^2 |c|^2).
  double mac(int measured, int explanation) const;
  /// Units (model modes, or doubles that no measurement can part) whose frequency lies in the band and that
  /// no explanation uses.
  std::vector<int> missing_modes(const Law& law, const std::vector<int>& used) const;

 private:
  /// Model modes that no measurement can part.
  struct Unit {
    std::vector<int> model;
    double ln_eigenvalue = 0.0;
    double price_missing = 0.0;
  };
  double pair_cost(const Candidate& measured, const Explanation& explanation, const Law& law,
                   double tolerance) const;
  void settle_shared_groups(const std::vector<int>& unit_of, Assignment& assignment) const;
  void make_units(const ModelModes& model, double least_step, double loss_factor);
  void make_explanations(const ModelModes& model);
  bool in_band(double ln_f) const { return ln_f >= band_lo_ && ln_f <= band_hi_; }
  /// ln f that a measured mode must exceed to lie above all model modes.
  double highest_ln_frequency(const Law& law, double tolerance) const;
  std::vector<bool> explained_units(const std::vector<int>& used) const;

  std::vector<Candidate> candidates_;
  std::vector<Unit> units_;
  std::vector<Explanation> explanations_;  ///< ascending
  std::vector<double> explanation_ln_eigenvalue_;
  std::vector<int> explanation_of_unit_;  ///< of each unit alone
  double reference_ln_f_ = 0.0;
  double band_lo_ = 0.0;  ///< ln f
  double band_hi_ = 0.0;
  double expected_slope_ = 0.0;
  bool has_constants_ = false;
  bool amplitude_known_ = false;
  bool scales_with_modulus_ = true;
};

}  // namespace struna::ident
