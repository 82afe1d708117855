#include "server/maps/store/map_tile.h"

#include <cmath>

#include "core/map/map_builder.h"

namespace dcloc::server {
namespace {

bool Contains(const Rectangle& bounds_m, const Eigen::Vector3d& p_map) {
  return p_map.x() >= bounds_m.min_x && p_map.x() <= bounds_m.max_x &&
         p_map.y() >= bounds_m.min_y && p_map.y() <= bounds_m.max_y;
}

/// Keyframes whose landmarks may lie in the rectangle.
std::vector<std::size_t> KeyframesNear(const RadarMap& map, const Rectangle& bounds_m) {
  const Eigen::Vector3d centre(0.5 * (bounds_m.min_x + bounds_m.max_x),
                               0.5 * (bounds_m.min_y + bounds_m.max_y), 0.0);
  const double half_diagonal_m =
      0.5 * std::hypot(bounds_m.max_x - bounds_m.min_x, bounds_m.max_y - bounds_m.min_y);
  return map.KeyframesWithin(centre, half_diagonal_m + MapBuilderOptions().max_keyframe_distance_m);
}

template <typename Item>
std::vector<Item> EvenlyTaken(const std::vector<Item>& items, std::size_t max_count) {
  const std::size_t step = (items.size() + max_count - 1) / max_count;
  std::vector<Item> taken;
  for (std::size_t i = 0; i < items.size(); i += step) taken.push_back(items[i]);
  return taken;
}

}  // namespace

MapTile ReadTile(const RadarMap& map, const Rectangle& bounds_m, std::size_t max_point_count,
                 std::size_t max_keyframe_count) {
  MapTile tile{.origin_map_m = {bounds_m.min_x, bounds_m.min_y, map.info().min_map_m.z()}};
  for (const std::size_t index : KeyframesNear(map, bounds_m)) {
    const Keyframe keyframe = map.keyframe(index);
    const Pose3& T_map_keyframe = keyframe.T_map_keyframe;
    if (Contains(bounds_m, T_map_keyframe.translation_m)) {
      tile.keyframes.push_back(
          {.p_tile_m = (T_map_keyframe.translation_m - tile.origin_map_m).cast<float>(),
           .accuracy = map.accuracy(index)});
    }
    for (const MapPoint& point : keyframe.points) {
      const Eigen::Vector3d p_map =
          T_map_keyframe * Eigen::Vector3d(point.x_m, point.y_m, point.z_m);
      if (!Contains(bounds_m, p_map)) continue;
      tile.points.push_back(
          {.p_tile_m = (p_map - tile.origin_map_m).cast<float>(), .rcs_dbsm = point.rcs_dbsm});
    }
  }
  tile.point_count = static_cast<std::int64_t>(tile.points.size());
  tile.points = EvenlyTaken(tile.points, max_point_count);
  tile.keyframes = EvenlyTaken(tile.keyframes, max_keyframe_count);
  return tile;
}

}  // namespace dcloc::server
