#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/passes/placed_pass.h"

namespace dcloc {

struct NewStreetOptions {
  double keyframe_spacing_m = 10.0;
  double lane_m = 15.0;  ///< of a keyframe: who drove nearer drove the same street
};

/// Streets that passes drove beyond a map.
struct NewStreets {
  std::vector<Pose3> T_local_keyframes;  ///< of those that enough witnesses drove
  double joined_m = 0.0;                 ///< their length
  double unproven_m = 0.0;               ///< of those that too few drove
};

/// Keyframes along the scans of `passes` that count beyond the map, where `min_witnesses` vehicles
/// or days at least drove. `T_local_keyframes` are the map's; all are relative to its `origin_m`.
NewStreets FindNewStreets(std::span<const Pose3> T_local_keyframes,
                          std::span<const PlacedPass> passes, const Eigen::Vector3d& origin_m,
                          int min_witnesses, const NewStreetOptions& options = {});

}  // namespace dcloc
