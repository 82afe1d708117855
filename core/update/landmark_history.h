#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/radar/stamp.h"
#include "core/update/presence.h"

namespace dcloc {

/// What an update makes of a landmark.
enum class LandmarkFate {
  kKept,          ///< was in the map, and is
  kAdded,         ///< new, and in the map
  kRemoved,       ///< was in the map, and is gone
  kIntermittent,  ///< there one day and not the next: not in the map
  kUnproven,      ///< seen, by too few witnesses or too rarely: not in the map
};
inline constexpr const char* kLandmarkFateNames[] = {"kept", "came", "went", "comes and goes",
                                                     "unproven"};

/// A landmark of the base map, or a place where the passes saw something else.
struct LandmarkHistory {
  LandmarkFate fate = LandmarkFate::kKept;
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
  Presence presence;
  std::vector<PassEvidence> passes;  ///< in the order of their stamps
  std::optional<Stamp> first_seen;   ///< by the passes of the update
  std::optional<Stamp> last_seen;
  int witness_count = 0;  ///< vehicles or days that saw it
  int vehicle_count = 0;  ///< that saw it
  /// Those that looked, would probably have seen it, and did not; each by its first pass.
  std::vector<std::size_t> absence_witnesses;
};

}  // namespace dcloc
