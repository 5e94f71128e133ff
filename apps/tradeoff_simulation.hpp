#pragma once

#include <string>
#include <vector>

#include "apps/tradeoff_chart.hpp"
#include "fem/motion.hpp"
#include "fem/scene.hpp"

namespace struna::apps {

/// A scene with its motion, run for `duration` from its beginning.
struct SimulationProblem {
  std::string name;
  fem::Scene scene;
  fem::MotionHistory motion;
  double duration = 0.0;  ///< [s]
};

/// A straight wire (501 mm, 25 elements) in a band (321 mm, 16 elements), gap 0.15 mm, k = 1e5 N/m, c = 100 N
/// s/m, swept from 100 to 1000 Hz in 0.1 s with 60 m/s^2. It starts in the middle of its gap, so that every
/// method starts alike.
SimulationProblem rattling_wire_problem(fem::ContactLaw law);

/// A user's scene; at most `longest` seconds of it. Throws Error without drive, measurement or simulation.
SimulationProblem scene_simulation_problem(const fem::Scene& scene, const std::string& name, double longest);

/// Displacement at the middle of the measured body (largest error over largest displacement) and transfer
/// function (the measured outputs' spectra over the band; the motion is common to all runs), over method and
/// step or tolerance. The reference is the modal method at a tolerance of 1e-6; its own error is its distance
/// from a run at a fixed step. Where the two part (contact is sensitive to small differences), the comparison
/// ends: a chart's notes tell when.
std::vector<TradeoffChart> tradeoff_simulation(const SimulationProblem& problem, const TradeoffRun& run);

/// A clamped wire of 28 elements against a one-sided stop at its middle (gap 1 mm, k = 1e5 N/m, c = 100 N
/// s/m, no adhesion), shaken with 20 sin(2 pi 25 t) m/s^2: displacement over method, step, tolerance and
/// modes stepped; error of the gap, over `duration` [s].
TradeoffChart wire_against_stop(double duration, const TradeoffRun& run);

/// The wire against its stop, and the rattling wire under each contact law.
std::vector<TradeoffChart> tradeoff_simulation(const TradeoffRun& run);

}  // namespace struna::apps
