#pragma once

#include <vector>

#include "apps/tradeoff_linear.hpp"

namespace struna::apps {

/// How a body is made into elements. The program's own way is curved elements with consistent mass; the
/// others are what is common elsewhere, for comparison.
enum class MeshKind {
  curved_consistent,  ///< fem::assemble
  chords_consistent,  ///< straight elements between the nodes
  curved_lumped,
  chords_lumped
};

/// The model of a body with `elements` elements. Lumped: the diagonal of the straight element's mass, scaled
/// to its total (Hinton, Rock & Zienkiewicz, Earthq. Eng. Struct. Dyn. 4 (1976) 245): half the mass at each
/// node, m h^2/78 against bending rotations, half the polar inertia about the axis.
fem::Model tradeoff_mesh(const fem::Body& body, int elements, MeshKind kind);

/// Natural frequencies and transfer function over element count, geometry and mass.
std::vector<TradeoffChart> tradeoff_model(const LinearProblem& problem, const TradeoffRun& run);

/// The straight and the curved wire.
std::vector<TradeoffChart> tradeoff_model(const TradeoffRun& run);

}  // namespace struna::apps
