#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/study_file.hpp"
#include "apps/tradeoff_chart.hpp"
#include "ident/mode.hpp"
#include "ident/transfer_estimate.hpp"

namespace struna::apps {

/// Records whose modes are known: exactly (simulated), or as well as the finest estimate tells.
struct TransferProblem {
  std::string name;
  double duration = 0.0;  ///< of the records together [s]
  long draws = 1;         ///< records of the same structure under other draws of excitation and noise
  /// The function of one draw, as `struna frf` would make it with these settings.
  std::function<ident::TransferEstimate(long draw, const TransferSettings& settings)> estimate;
  std::vector<ident::Mode> truth;
  fem::Damping damping = fem::Damping::structural;
  std::string reference;
  double reference_error = 0.0;  ///< of the loss factor, relative
};

/// A clamped straight wire of 0.68 m, eta = 0.02, shaken at random (10 to 700 Hz, flat acceleration): base
/// displacement and force at the far support at 2 kHz, the closed form's steady state cut out of a longer,
/// non-periodic run, with white noise: `noise` of the force's rms, and 3e-4 of the displacement's. Seven
/// modes. Exact.
TransferProblem shaken_wire_problem(double duration, double noise, long draws);

/// A study's records: the truth is what is found without flags at a third of the records' length per segment;
/// its standard errors are the reference's. Throws Error when nothing is found.
TransferProblem study_transfer_problem(const Study& study, const std::string& name);

/// Estimators, windows and overlaps over resolution (methods that cannot follow one are left out there): rms
/// over modes and draws of the relative error of eta, by the default mode method told where the modes are.
/// Time: spectra and estimate; for files, reading too.
TradeoffChart tradeoff_resolution(const TransferProblem& problem, const TradeoffRun& run);

/// Estimators at the default settings over the record's length, 7.5 to 120 s.
TradeoffChart tradeoff_record_length(double noise, long draws, const TradeoffRun& run);

/// The shaken wire: 30 s over resolution at 0.1 and 1 % noise, and over record length at 1 %.
std::vector<TradeoffChart> tradeoff_transfer(const TradeoffRun& run);

}  // namespace struna::apps
