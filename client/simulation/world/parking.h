#pragma once

#include <cstdint>
#include <vector>

#include "client/simulation/world/vehicle.h"
#include "client/simulation/world/world.h"

namespace dcloc::simulation {

/// A vehicle that stands at the kerb for a whole pass.
struct ParkedVehicle {
  std::size_t slot = 0;
  Vehicle vehicle;
  Pose2 T_map_body;
};

/// The parked vehicles of pass `pass_index`, by slot. In every pass but 0, each slot is drawn anew
/// with probability `change_share`: another vehicle standing a little otherwise, or none. So about
/// that share of the vehicles of pass 0 is gone or replaced.
std::vector<ParkedVehicle> ParkVehicles(const World& world, std::uint64_t seed, int pass_index,
                                        double change_share);

}  // namespace dcloc::simulation
