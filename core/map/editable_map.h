#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"
#include "core/map/map_file.h"
#include "core/map/radar_map.h"

namespace dcloc {

/// A keyframe and its landmarks, on their own.
struct EditableKeyframe {
  KeyframeRecord record{};  ///< `first_point` and `point_count` mean nothing here
  std::vector<MapPoint> points;
};

/// A map that can be changed. What is not touched keeps its bits: poses and positions stay as the
/// file holds them, so that `ToMapBytes` of `ToEditable` gives the same file.
struct EditableMap {
  InfoRecord info{};  ///< `name_size_bytes` means nothing here
  std::string name;
  std::string description;
  std::vector<EditableKeyframe> keyframes;

  std::optional<GeodeticAnchor> Anchor() const;
  Eigen::Vector3d Origin_m() const;
  std::size_t PointCount() const;
};

EditableMap ToEditable(const RadarMap& map);

/// The file's bytes. FailedPrecondition for a map without landmarks; DataLoss names the first value
/// that no map may hold.
absl::StatusOr<std::vector<std::byte>> ToMapBytes(const EditableMap& map);

/// The keyframe's pose relative to the local origin.
Pose3 PoseOf(const KeyframeRecord& record);

/// The record of a keyframe at `T_local_keyframe` that has no landmark yet.
KeyframeRecord RecordOf(const Pose3& T_local_keyframe);

/// The landmark in its keyframe's frame. With `kHasHeightsFlag` its z is the height over the
/// radars.
Eigen::Vector3d PositionOf(const MapPoint& point);

}  // namespace dcloc
