#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "client/simulation/simulation.h"
#include "core/map/radar_map.h"
#include "core/passes/placed_pass.h"

namespace dcloc::benchmarks {

/// A simulated town, 10 % of whose scatterers are replaced and whose parked vehicles change daily:
/// a pass of before, three passes of three vehicles since, and one of a fourth that judges.
struct Town {
  simulation::AgedWorld aged;
  SimulatedPass base;
  std::vector<SimulatedPass> passes;
  Drive held_out;
};

Town MakeAgedTown(std::uint64_t seed, double length_m, int rig_size);

/// The same in any world; `options` have four live passes.
Town MakeAgedTown(const SimulationOptions& options);

/// The passes of `town` in its base map.
std::vector<PlacedPass> PlacePasses(const std::shared_ptr<const RadarMap>& base, const Town& town);

/// A map of the update's passes alone, at their true poses.
std::shared_ptr<const RadarMap> MadeAnew(const Town& town);

/// The median error of `drive` localized in `map`, by the true poses.
double MedianError_m(const std::shared_ptr<const RadarMap>& map, const Drive& drive);

}  // namespace dcloc::benchmarks
