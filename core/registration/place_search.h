#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/map/radar_map.h"

namespace dcloc {

struct PlaceSearchOptions {
  double cell_m = 1.0;   ///< step between positions; headings step likewise
  double reach_m = 6.0;  ///< the vehicle is this near to a keyframe along each of the map's axes
  int max_count = 12;
};

/// A place of the map where points may have been seen.
struct PlaceHypothesis {
  std::size_t keyframe;      ///< the nearest one
  Pose2 T_keyframe_vehicle;  ///< in its xy plane, within half a step
  double score;              ///< mean likelihood of the points, [0, 1]
};

/// Up to `max_count` best places of `points` (vehicle xy) in the whole map, best first, no two
/// within four steps of one another. Exhaustive over positions and headings on a coarse grid, tile
/// by tile: the cost grows with the length of street, the memory does not.
std::vector<PlaceHypothesis> SearchPlaces(const RadarMap& map,
                                          std::span<const Eigen::Vector2f> points,
                                          const PlaceSearchOptions& options = {});

}  // namespace dcloc
