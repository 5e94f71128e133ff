#pragma once

#include <string>

#include "fem/simulation.hpp"

namespace struna::apps {

/// What --explain tells of a run: meshes, modes, steps, planes, contact, samples, and whether linear beam
/// theory holds.
std::string simulation_explanation(const fem::Scene& scene, const fem::SimulationReport& report);

}  // namespace struna::apps
