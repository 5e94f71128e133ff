#pragma once

#include <vector>

#include "apps/tradeoff_linear.hpp"

namespace struna::apps {

/// How a truncated modal sum gets at a support's force.
enum class ModalSum {
  plain,             ///< modes of the held body alone, forces from the stiffness rows of the support
  static_correction  ///< modes on top of the static shape, forces from momentum balance
};

/// A support's force over a support's motion [N/m] by the sum over the lowest `modes` modes, lines x outputs.
/// With d the unit motion, S_i, S_o the static shapes of a unit motion of the driven and of the measured
/// support, s_k, s_m the factors of K1 and M in the dynamic stiffness:
///   static_correction  y_r = -s_m G_i/(s_k lambda_r + s_m),  H = s_k S_o'K1 S_i + s_m (S_o'M S_i + sum G_o
///   y),
///                      G = phi'M S
///   plain              y_r = -(phi'(s_k K1 + s_m M) d)/(s_k lambda_r + s_m),
///                      H = row (s_k K1 + s_m M) (d + sum phi_r y_r)
/// Throws Error unless the problem drives and measures supports.
Eigen::MatrixXcd modal_response(const LinearProblem& problem, const fem::Model& model, int modes,
                                ModalSum sum, const Eigen::VectorXd& line_hz);

/// Transfer function by direct solution over the mesh and by modal sums over modes kept.
std::vector<TradeoffChart> tradeoff_harmonic(const LinearProblem& problem, const TradeoffRun& run);

/// The straight and the curved wire.
std::vector<TradeoffChart> tradeoff_harmonic(const TradeoffRun& run);

}  // namespace struna::apps
