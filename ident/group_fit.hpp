#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ident/mode_groups.hpp"
#include "ident/pole_fit.hpp"
#include "ident/second_pole.hpp"

namespace struna::ident {

/// One group's fit with what is needed to judge its poles. Refers to the window and to the modes outside:
/// both must outlive it. `band`: of the whole function, of which the window is a part.
class GroupFit {
 public:
  GroupFit(const TransferFunction& window, const std::vector<Mode>& outside, const Span& band,
           const PoleFitOptions& options)
      : window_(&window), outside_(&outside), band_(band), options_(options) {
    spacing_ = band_of(window).spacing_hz;
  }

  bool can_fit(std::size_t poles) const;
  void fit(const std::vector<Pole>& poles);
  const PoleFit& result() const { return fit_; }
  long outputs() const { return static_cast<long>(window_->outputs.size()); }

  /// Chi-square per degree of freedom: above 1 by what sigma does not explain.
  double lack() const;
  /// What a further pole must take out of the sum of squares (Schwarz, Ann. Statist. 6 (1978) 461).
  double penalty() const;
  /// Why pole r is no mode; empty when it has support.
  std::string objection(long r) const;
  /// The least significant of the first `targets` poles with an objection.
  std::optional<long> worst(long targets) const;
  /// Its peak over the sum of the magnitudes of all shares there and of the residual terms, as norms over the
  /// outputs. Against the function itself a trifle would look large in an antiresonance, where large shares
  /// cancel.
  double share(long r) const;
  /// Of its constants, in standard errors.
  double significance(long r) const;
  /// Of two poles' constants, each over its sigma: 1 when parallel.
  double assurance(long r, long s) const;
  /// Rms of the residual within a bandwidth, as far as it goes on from line to line (noise does not), over
  /// the circle's radius.
  double scatter_of(long r) const;
  /// Whether the lines within a bandwidth, all else taken off, lie off its circle: by more than
  /// poor_circle_misfit of their standard deviations and poor_circle_scatter of its radius (rms).
  bool is_poor(long r) const;
  /// Whether two modes stand behind it (looks_double).
  bool is_double(long r) const;
  /// Whether a second pole would explain the residual around it, and from which distance on it would show.
  SecondPole second_pole(long r) const;

 private:
  /// First line within so many bandwidths of a pole, and the one after the last.
  std::pair<long, long> lines_around(const Pole& pole, double bandwidths) const;
  const Pole& pole(long r) const { return fit_.poles[static_cast<std::size_t>(r)]; }

  const TransferFunction* window_;
  const std::vector<Mode>* outside_;
  Span band_;
  PoleFitOptions options_;
  double spacing_;
  PoleFit fit_;
};

/// Adds to the noise of each column a constant variance for the model's own error, as large as the residual
/// (over the present sigma of `window`) asks for; `noise`: the window with the noise's own sigma. Else the
/// lines of least noise, far from resonance, would rule the fit with what the model lacks there.
void weigh_model_error(const TransferFunction& noise, const Eigen::MatrixXcd& residual,
                       TransferFunction& window);

}  // namespace struna::ident
