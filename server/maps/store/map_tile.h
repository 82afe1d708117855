#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/map/radar_map.h"
#include "server/maps/catalogue/coverage.h"

namespace dcloc::server {

/// A landmark as a viewer draws it.
struct TilePoint {
  Eigen::Vector3f p_tile_m;  ///< relative to the tile's origin, along the map's axes
  float rcs_dbsm = 0.0F;
};

/// A keyframe likewise.
struct TileKeyframe {
  Eigen::Vector3f p_tile_m;
  std::optional<KeyframeAccuracy> accuracy;
};

/// A rectangle of a map, with coordinates relative to its corner of least x and y: far from a map's
/// origin, single precision would be too coarse.
struct MapTile {
  Eigen::Vector3d origin_map_m;
  std::int64_t point_count = 0;  ///< in the rectangle; `points` are some of them
  std::vector<TilePoint> points;
  std::vector<TileKeyframe> keyframes;
};

/// The landmarks and keyframes within `bounds_m`, at most `max_point_count` and
/// `max_keyframe_count` (> 0), evenly taken. Deterministic.
MapTile ReadTile(const RadarMap& map, const Rectangle& bounds_m, std::size_t max_point_count,
                 std::size_t max_keyframe_count);

}  // namespace dcloc::server
