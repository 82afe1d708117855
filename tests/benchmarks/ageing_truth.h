#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "client/simulation/simulation.h"
#include "core/update/map_update.h"

namespace dcloc::benchmarks {

/// What an update made of a simulated town that aged, counted by the truth.
struct AgeingCounts {
  std::size_t went = 0;  ///< landmarks of scatterers that went, and nothing else is near
  std::size_t went_gone = 0;
  std::size_t stood = 0;  ///< standing scatterers that the base map has and two passes saw
  std::size_t stood_lost = 0;
  std::size_t came = 0;  ///< new scatterers that two passes saw, where nothing stood
  std::size_t came_found = 0;
  std::size_t landmarks = 0;  ///< of the new version
  std::size_t parked = 0;     ///< of them: parts of vehicles that park
  std::size_t base_parked = 0;
};

/// `placed` are `passes` in the base map. Only their scans that count can tell an update anything.
AgeingCounts CountAgeing(const MapUpdate& update, const simulation::AgedWorld& aged,
                         const SimulatedPass& base, const std::vector<SimulatedPass>& passes,
                         const std::vector<PlacedPass>& placed);

}  // namespace dcloc::benchmarks
