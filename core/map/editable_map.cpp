#include "core/map/editable_map.h"

#include <cassert>
#include <limits>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/map/keyframe_index.h"
#include "core/map/map_content.h"

namespace dcloc {

std::optional<GeodeticAnchor> EditableMap::Anchor() const { return AnchorOf(info); }

Eigen::Vector3d EditableMap::Origin_m() const {
  return Eigen::Vector3d::Map(info.local_origin_m.data());
}

std::size_t EditableMap::PointCount() const {
  std::size_t count = 0;
  for (const EditableKeyframe& keyframe : keyframes) count += keyframe.points.size();
  return count;
}

EditableMap ToEditable(const RadarMap& map) {
  const absl::StatusOr<MapFileView> view = ParseMapFile(map.bytes());
  assert(view.ok());  // a RadarMap has been parsed before
  EditableMap editable{.info = view->info,
                       .name = std::string(view->name),
                       .description = std::string(view->description),
                       .keyframes = {}};
  editable.keyframes.reserve(view->keyframes.size());
  for (const KeyframeRecord& record : view->keyframes) {
    const auto points = view->points.subspan(record.first_point, record.point_count);
    editable.keyframes.push_back({record, {points.begin(), points.end()}});
  }
  return editable;
}

absl::StatusOr<std::vector<std::byte>> ToMapBytes(const EditableMap& map) {
  const std::size_t point_count = map.PointCount();
  if (point_count == 0) return absl::FailedPreconditionError("the map would have no landmark");
  constexpr std::size_t kMaxRecords = std::numeric_limits<std::uint32_t>::max();
  if (point_count > kMaxRecords || map.keyframes.size() > kMaxRecords) {
    return absl::FailedPreconditionError(
        absl::StrFormat("the map would have %d landmarks and %d keyframes; a file holds %d of each",
                        point_count, map.keyframes.size(), kMaxRecords));
  }
  std::vector<KeyframeRecord> keyframes;
  std::vector<MapPoint> points;
  keyframes.reserve(map.keyframes.size());
  points.reserve(point_count);
  for (const EditableKeyframe& keyframe : map.keyframes) {
    keyframes.push_back(keyframe.record);
    keyframes.back().first_point = points.size();
    keyframes.back().point_count = static_cast<std::uint32_t>(keyframe.points.size());
    points.insert(points.end(), keyframe.points.begin(), keyframe.points.end());
  }
  InfoRecord info = map.info;
  info.name_size_bytes = static_cast<std::uint32_t>(map.name.size());
  const std::vector<IndexRecord> index = MakeIndex(keyframes, info.index_cell_m);
  const MapFileView view{.info = info,
                         .name = map.name,
                         .description = map.description,
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

KeyframeRecord RecordOf(const Pose3& T_local_keyframe) {
  const Eigen::Vector3d& t = T_local_keyframe.translation_m;
  const Eigen::Quaterniond& q = T_local_keyframe.rotation;
  return {.translation_local_m = {t.x(), t.y(), t.z()},
          .rotation_wxyz = {q.w(), q.x(), q.y(), q.z()},
          .first_point = 0,
          .point_count = 0,
          .accuracy = 0};
}

Eigen::Vector3d PositionOf(const MapPoint& point) { return {point.x_m, point.y_m, point.z_m}; }

}  // namespace dcloc
