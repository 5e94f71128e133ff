#pragma once

#include <vector>

#include "apps/tradeoff_chart.hpp"
#include "ident/mode.hpp"

namespace struna::apps {

/// A transfer function whose modes are known: exactly (simulated), or as well as all its lines tell.
struct ModesProblem {
  std::string name;
  std::vector<ident::TransferFunction> draws;  ///< the same function under several draws of its noise
  std::vector<ident::Mode> truth;
  std::string reference;
  double frequency_reference_error = 0.0;    ///< relative
  double loss_factor_reference_error = 0.0;  ///< relative
  fem::Damping damping = fem::Damping::structural;
};

/// The mode found nearest to a true one, within its half-power bandwidth either side; null when there is
/// none.
const ident::Mode* nearest_mode(const std::vector<ident::Mode>& found, const ident::Mode& truth);

/// Eight modes between 22 and 970 Hz, one pair three half-power bandwidths apart, three outputs, 0 to 1200 Hz
/// in steps of 0.25 Hz, with complex normal noise of `noise` times each output's rms; `draws` of it. Exact.
ModesProblem eight_modes_problem(double noise, int draws);

/// A measured function: the truth is what the default method finds on all its lines; its own standard errors
/// are the reference's. Throws Error when it finds none.
ModesProblem measured_modes_problem(const ident::TransferFunction& tf, const std::string& name);

/// Methods over lines per half-power bandwidth (every n-th line is kept): natural frequency and loss factor,
/// rms over modes and draws of the relative errors. A mode that was not found counts as 100 % off in both.
std::vector<TradeoffChart> tradeoff_modes(const ModesProblem& problem, const TradeoffRun& run);

/// The built-in problems: eight modes at 0.1, 1 and 5 % noise.
std::vector<TradeoffChart> tradeoff_modes(const TradeoffRun& run);

}  // namespace struna::apps
