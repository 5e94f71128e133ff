#pragma once

#include <vector>

#include "ident/mode.hpp"
#include "ident/resonance.hpp"

namespace struna::ident {

struct BandFitOptions {
  fem::Damping damping = fem::Damping::structural;
  bool sigma_known = true;
  bool search_residual = true;  ///< add poles while the residual demands one
  /// Tried first of all where no mode is within half their bandwidth, by the same tests.
  std::vector<Pole> candidates;
};

/// Reason of a candidate that its window has no lines for.
inline constexpr const char* too_few_lines = "too few lines";

struct BandFit {
  std::vector<Mode> modes;  ///< ascending; flags double_mode, poor_circle, not_converged
  std::vector<RejectedCandidate> rejected;
};

/// All modes of a long band, group by group (mode_groups.hpp: each group in its window with the neighbours in
/// it, the shares of all others taken off, residual terms for the rest), in rounds until no mode moves by
/// more than a tenth of its standard error. So the cost grows with the band only, and a slow drift of the
/// structure over the band (a modulus that rises) stays out of the fits. Where noise does not explain the
/// residual, the window narrows (8, 5, 3 bandwidths), and a constant variance for the model's own error joins
/// that of the noise. Within each group
///   drop   poles without support: outside 1e-5 < eta < 0.5, half-power band below 0.3 line spacings,
///          constants below six standard errors, share below 3 % of all shares around, two poles nearer than
///          0.05 bandwidths (one stays), a residual within a bandwidth that goes on from line to line above
///          10 % of the circle's radius unless the start brought a circle or a candidate stands there;
///   add    the pole that would take most out of the residual, or a candidate, if the refitted sum of squares
///          falls by more than (2 + 2 outputs) ln(data) (Schwarz, Ann. Statist. 6 (1978) 461) times the
///          scatter per degree of freedom times the number of neighbouring lines that are worth one, and
///          every pole then has support; within a bandwidth of another also its constants must point
///          elsewhere than the other's (assurance below 0.9): else it only mends the other's shape.
/// Poles outside the band, up to 1.3 times its end, are kept as background once they gained 0.3 of that
/// (near Akaike's penalty, as nobody claims them), whatever their damping, which nothing tells: a mode beyond
/// bends the function inside. An added pole within a bandwidth of the band's end is not claimed. Start modes
/// need frequency and loss factor; constants where they are known. `tf` in circle form with sigma.
BandFit fit_band(const TransferFunction& tf, const std::vector<Mode>& start, const BandFitOptions& options);

}  // namespace struna::ident
