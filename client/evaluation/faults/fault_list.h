#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/evaluation/faults/fault.h"
#include "client/evaluation/faults/worlds.h"

namespace dcloc::faults {

/// All faults, family by family; a few that show whether everything works where `quick`.
std::vector<Fault> AllFaults(bool quick);

/// What a campaign tries, and where.
struct Selection {
  std::vector<Fault> faults;
  std::vector<World> worlds;
};

/// What of `all` the names ask for: each is a fault's id, a family, a kind of world, or a world.
/// Names of faults narrow the faults, names of worlds the worlds; no names ask for everything.
/// InvalidArgument names one that there is not, and those that there are.
absl::StatusOr<Selection> Select(Selection all, const std::vector<std::string>& names);

}  // namespace dcloc::faults
