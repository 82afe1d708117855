#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "client/simulation/world/world.h"

namespace dcloc::simulation {

/// What happens to a world after its map was made. Zero: nothing of the kind.
struct AgeingOptions {
  /// Of the scatterers that stay: gone, with another one 2 to 5 m further along the wall or street.
  double replaced_share = 0.0;
  double site_m = 0.0;       ///< length of a construction site at the right kerb, behind a fence
  int post_count = 0;        ///< new posts at the left kerb, every 4 m
  double gone_wall_m = 0.0;  ///< length of street whose houses on the left are gone
  int leaf_count = 0;        ///< weak reflections that wander, around each tree
};

/// A scatterer that a change brought or took.
struct ScattererChange {
  bool came = false;
  std::string cause;  ///< "replaced", "site", "posts", "gone wall", "leaves"
  Scatterer scatterer;
};

struct AgedWorld {
  World world;
  std::vector<ScattererChange> changes;
};

/// `world` after these changes. They depend on the seed and on each option alone: asking for one
/// more leaves the others as they are, but that what a site or a gone wall takes is not replaced.
AgedWorld Age(const World& world, const AgeingOptions& options, std::uint64_t seed);

/// Whether the options change anything.
bool ChangesWorld(const AgeingOptions& options);

}  // namespace dcloc::simulation
