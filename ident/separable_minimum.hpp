#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <utility>

namespace struna::ident {

struct Outcome {
  bool converged = false;
  int iterations = 0;
};

/// (H + damping diag H)^-1 gradient, H n x n, symmetric and positive definite.
Eigen::VectorXd damped_step(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& gradient, double damping);

/// Levenberg-Marquardt from `state` until less than `tolerance` standard errors is to be gained. A Problem
/// has step(state) (gradient of -chi_square/2 and its Gauss-Newton hessian), moved(state, delta),
/// size_of(delta, state) (of a step, in natural units) and degrees_of_freedom(); a State has chi_square.
/// Where the residual is large (the model lacks something), the true curvature is c times that of Gauss and
/// Newton and their steps overshoot to and fro, by c - 1 each. The decrease of such a step is 2 - c of the
/// promised one: half of what that lacks as damping brings either kind of direction home at a like rate.
template <class Problem, class State>
Outcome minimise(const Problem& problem, int max_iterations, double tolerance, State& state) {
  constexpr double least_damping = 1e-4, damping_after_failure = 0.03;
  double damping = least_damping;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const auto step = problem.step(state);
    bool accepted = false;
    while (!accepted && damping < 1e12) {
      const Eigen::VectorXd delta = damped_step(step.hessian, step.gradient, damping);
      const double promise = delta.dot(step.gradient);
      const double per_dof = state.chi_square / static_cast<double>(problem.degrees_of_freedom());
      if (problem.size_of(delta, state) < 1e-12 || promise < tolerance * tolerance * per_dof)
        return {true, iteration};
      State trial = problem.moved(state, delta);
      if (trial.chi_square < state.chi_square) {
        const double kept = std::clamp((state.chi_square - trial.chi_square) / promise, 0.0, 1.0);
        damping = std::max({least_damping, 0.1 * damping, 0.5 * (1.0 - kept)});
        state = std::move(trial);
        accepted = true;
      } else {
        if (promise < 1e-12 * state.chi_square) return {true, iteration};  // the decrease drowns in rounding
        damping = std::max(damping_after_failure, 10.0 * damping);
      }
    }
    if (!accepted) return {false, iteration};
  }
  return {false, max_iterations};
}

}  // namespace struna::ident
