#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/comparison.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/wiring.hpp"

namespace struna::ident {

/// Reasons to question a result although nothing failed (docs/doubts.md). In the comments: what Doubt's
/// numbers are.
enum class DoubtKind {
  shapes_disagree,  ///< count of `of` pairs agree; value: their median MAC; names: all outputs; maybe a
                    ///< remedy
  modes_unpaired,   ///< count of `of` sound modes have no model mode; maybe a remedy
  modes_unseen,   ///< count of `of` model modes in the band, as strong as the paired ones, were not measured
  pairing_open,   ///< other pairs are nearly as probable as the count pairs of `of` modes; value: the modulus
                  ///< that they give, 0: chance; other: their odds
  sign_reversed,  ///< all constants have the sign opposite to the model's
  level_offset,   ///< value: measured over model's strength; count: of how many modes
  law_misfit,  ///< names: "modulus" or "loss factor", the law; value: rms/sigma; other: rms scatter, relative
  low_frac,    ///< names: outputs; value: their lowest FRAC; other: FRAC that the noise would leave
  scatter_differs,  ///< count of `of` modes scatter more over the bootstrap than stated; value, other:
                    ///< pooled ratio of their frequencies and of their loss factors
  viscous_closer    ///< value, other: mean level error of the structural and of the viscous model [dB]
};
std::string to_string(DoubtKind kind);  ///< "shapes_disagree", …

struct Doubt {
  DoubtKind kind = DoubtKind::shapes_disagree;
  int count = 0;
  int of = 0;
  double value = 0.0;
  double other = 0.0;
  std::vector<std::string> names;
  std::optional<Remedy> remedy;
};

/// What is doubted, and what to do: one sentence or two, for a terminal, a file or a page.
std::string sentence(const Doubt& doubt);

/// Doubts about modes, model and laws. `modes`, `model`, `drive`, `measurement`, `options` as given to
/// identify_parameters, `identified` as returned by it.
std::vector<Doubt> identification_doubts(const ModeSet& modes, const fem::Model& model,
                                         const fem::Drive& drive, const fem::Measurement& measurement,
                                         const FitOptions& options, const IdentifiedParameters& identified);

/// Doubts that the predictions raise: `modes` tells the damping model that the modes were read with.
/// `identification`: those of identification_doubts; while one of them questions the model, which damping is
/// the closer one is not asked.
std::vector<Doubt> comparison_doubts(const Comparison& structural, const Comparison& viscous,
                                     const ModeSet& modes, const IdentifiedParameters& identified,
                                     const std::vector<Doubt>& identification);

/// Whether one of them says that scene, cables or units are not those of the measurement: then differences of
/// the predictions tell nothing of the damping.
bool question_the_model(const std::vector<Doubt>& doubts);

/// Whether the shapes disagree so grossly, no more than half of the pairs agreeing, that no pair can be
/// trusted.
bool shapes_disagree_grossly(const std::vector<Doubt>& doubts);

/// Takes the trust from all modes: E(f) and eta(f) at them become rejected, with the reason; the laws, which
/// predictions need to show the disagreement, stay.
void withdraw_trust(IdentifiedParameters& identified);

}  // namespace struna::ident
