#pragma once

#include <cstddef>
#include <functional>

#include "absl/status/statusor.h"
#include "core/geometry/pose.h"
#include "core/map/radar_map.h"

namespace dcloc {

/// How one map lies in another.
struct MapAlignment {
  Pose3 T_to_from;             ///< the frame of the map that is aligned, in the other one's
  std::size_t pair_count = 0;  ///< places of the one that were found in the other
  double rms_m = 0.0;          ///< of these, after alignment: how far the maps are bent
};

/// Finds one map in another by their landmarks alone, as drives are found in one another
/// (`PlaceFinder`): level, with a heading and a height. FailedPrecondition where no ground that
/// both show is found; Cancelled when `progress`, which gets the share done, returns false.
absl::StatusOr<MapAlignment> AlignMaps(const RadarMap& from, const RadarMap& to,
                                       const std::function<bool(double)>& progress);

}  // namespace dcloc
