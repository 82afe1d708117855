#include "core/map/map_parts.h"

#include <cassert>
#include <limits>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/map/keyframe_index.h"
#include "core/map/map_content.h"

namespace dcloc {

std::optional<GeodeticAnchor> MapParts::Anchor() const { return AnchorOf(info); }

Eigen::Vector3d MapParts::Origin_m() const {
  return Eigen::Vector3d::Map(info.local_origin_m.data());
}

std::size_t MapParts::PointCount() const {
  std::size_t count = 0;
  for (const KeyframePart& keyframe : keyframes) count += keyframe.points.size();
  return count;
}

MapParts TakeApart(const RadarMap& map) {
  const absl::StatusOr<MapFileView> view = ParseMapFile(map.bytes());
  assert(view.ok());  // a RadarMap has been parsed before
  MapParts parts{.info = view->info,
                 .name = std::string(view->name),
                 .description = std::string(view->description),
                 .keyframes = {}};
  parts.keyframes.reserve(view->keyframes.size());
  for (const KeyframeRecord& record : view->keyframes) {
    const auto points = view->points.subspan(record.first_point, record.point_count);
    parts.keyframes.push_back({record, {points.begin(), points.end()}});
  }
  return parts;
}

absl::StatusOr<std::vector<std::byte>> PutTogether(const MapParts& parts) {
  const std::size_t point_count = parts.PointCount();
  if (point_count == 0) return absl::FailedPreconditionError("the map would have no landmark");
  constexpr std::size_t kMaxRecords = std::numeric_limits<std::uint32_t>::max();
  if (point_count > kMaxRecords || parts.keyframes.size() > kMaxRecords) {
    return absl::FailedPreconditionError(
        absl::StrFormat("the map would have %d landmarks and %d keyframes; a file holds %d of each",
                        point_count, parts.keyframes.size(), kMaxRecords));
  }
  std::vector<KeyframeRecord> keyframes;
  std::vector<MapPoint> points;
  keyframes.reserve(parts.keyframes.size());
  points.reserve(point_count);
  for (const KeyframePart& keyframe : parts.keyframes) {
    keyframes.push_back(keyframe.record);
    keyframes.back().first_point = points.size();
    keyframes.back().point_count = static_cast<std::uint32_t>(keyframe.points.size());
    points.insert(points.end(), keyframe.points.begin(), keyframe.points.end());
  }
  InfoRecord info = parts.info;
  info.name_size_bytes = static_cast<std::uint32_t>(parts.name.size());
  const std::vector<IndexRecord> index = MakeIndex(keyframes, info.index_cell_m);
  const MapFileView view{.info = info,
                         .name = parts.name,
                         .description = parts.description,
                         .keyframes = keyframes,
                         .index = index,
                         .points = points};
  absl::Status status = CheckContent(view);
  if (status.ok()) status = CheckPoints(points);
  if (!status.ok()) return status;
  return WriteMapFile(view);
}

Pose3 PoseOf(const KeyframeRecord& record) {
  const auto& q = record.rotation_wxyz;
  return {.translation_m = Eigen::Vector3d::Map(record.translation_local_m.data()),
          .rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
}

Eigen::Vector3d PositionOf(const MapPoint& point) { return {point.x_m, point.y_m, point.z_m}; }

}  // namespace dcloc
