#pragma once

namespace struna::ident {

struct SchwarzTerms {
  double parameters = 0.0;        ///< real ones that are added
  double data = 0.0;              ///< real values that are fitted
  double line_correlation = 1.0;  ///< neighbouring ones that are worth one
  double scatter = 1.0;           ///< chi-square per degree of freedom
};

/// What added parameters must take out of a sum of squares over sigma^2: parameters ln(data), data counted by
/// their worth and the sum in units of its scatter (Schwarz, Ann. Statist. 6 (1978) 461).
double schwarz_penalty(const SchwarzTerms& terms);

}  // namespace struna::ident
