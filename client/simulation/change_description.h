#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "client/simulation/simulation.h"
#include "client/simulation/world/ageing.h"

namespace dcloc {

/// Scatterers that came or went, with cause and place in the map.
nlohmann::ordered_json ScattererChanges(const std::vector<simulation::ScattererChange>& changes);

/// The vehicles that stood at the kerb in a pass: middle, heading and size.
nlohmann::ordered_json ParkedVehicles(const SimulatedPass& pass);

/// The options of days, vehicles and ageing.
nlohmann::ordered_json AgeingDescription(const SimulationOptions& options);

}  // namespace dcloc
