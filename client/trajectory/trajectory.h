#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"
#include "core/radar/stamp.h"

namespace dcloc {

struct TrajectoryPose {
  Stamp stamp;
  Pose3 T_map_vehicle;
};

/// Where a vehicle was over time, by ascending stamp, one pose a stamp.
struct Trajectory {
  std::string name;
  /// Where the map's frame lies on the Earth; without it there are no latitudes.
  std::optional<GeodeticAnchor> anchor;
  std::vector<TrajectoryPose> poses;
};

/// Brings poses into that order; of equal stamps the last one stays.
void SortByStamp(std::vector<TrajectoryPose>& poses);

}  // namespace dcloc
