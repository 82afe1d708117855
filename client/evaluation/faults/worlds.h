#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/evaluation/robustness/course.h"

namespace dcloc::faults {

/// A place with a map drive and a live drive, as they are without a fault.
struct World {
  std::string kind;        ///< "town", "highway", "tunnel", "carla", "five-radars", "stop-and-go"
  std::string name;        ///< the kind with its number; unique, letters, digits and '-'
  std::uint64_t seed = 1;  ///< of its simulation, and of all that is drawn on it
  std::size_t radar_count = 1;
  std::function<absl::StatusOr<robustness::Course>()> load;
};

/// Simulated worlds, three of each kind, each with live drives of some 70 s; all follow from
/// `seed`, and no two seeds share a world. `quick` makes one town of 40 s.
std::vector<World> SimulatedWorlds(std::uint64_t seed, bool quick);

}  // namespace dcloc::faults
