#include "client/simulation/world/parking.h"

namespace dcloc::simulation {

std::vector<ParkedVehicle> ParkVehicles(const World& world, std::uint64_t seed, int pass_index,
                                        double change_share) {
  const auto pass = static_cast<std::uint64_t>(pass_index);
  std::vector<ParkedVehicle> parked;
  for (std::size_t slot = 0; slot < world.parking_slots.size(); ++slot) {
    Random change = MakeRandom(seed, Stream::kParkingChange, {pass, slot});
    const bool is_changed = pass_index != 0 && Chance(change, change_share);
    Random random = MakeRandom(seed, Stream::kParking, {is_changed ? pass : 0, slot});
    if (!Chance(random, world.parking_occupancy)) continue;
    ParkedVehicle vehicle{slot, MakeVehicle(random, 0.0), world.parking_slots[slot]};
    vehicle.T_map_body =
        vehicle.T_map_body * Pose2{{Uniform(random, -0.4, 0.4), Uniform(random, -0.15, 0.15)},
                                   Normal(random, 0.0, 0.02)};
    parked.push_back(std::move(vehicle));
  }
  return parked;
}

}  // namespace dcloc::simulation
