#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/planar_region.h"
#include "core/map/editable_map.h"

namespace dcloc {

enum class RegionSide { kInside, kOutside };

/// The landmarks of one side of `region`, which is in the map frame. A keyframe stays if it lies on
/// that side or has a landmark there; its pose and its landmarks keep their bits. So the parts of a
/// map, merged, are the map again. The frame and the anchor stay. InvalidArgument for an invalid
/// region; FailedPrecondition when no landmark is left.
absl::StatusOr<EditableMap> KeepSide(const EditableMap& map, const PlanarRegion& region,
                                     RegionSide side);

/// The pose of b's map frame in a's, by their anchors. The identity where both anchors are equal.
Pose3 FrameChange(const GeodeticAnchor& anchor_a, const GeodeticAnchor& anchor_b);

/// OK where two maps are known to share a frame or to have anchors that tie them together, or
/// `is_same_frame` says so. FailedPrecondition says what is missing.
absl::Status CheckFrames(const EditableMap& a, const EditableMap& b, bool is_same_frame);

struct MergeCounts {
  std::size_t shared_keyframes = 0;  ///< that both maps have, bit for bit
  std::size_t shared_landmarks = 0;  ///< likewise; each is in the result once
  /// Other landmarks of b within 0.4 m of one of a: probably one scatterer, mapped twice.
  std::size_t doubled_landmarks = 0;
};

/// `a` with what `b` has more, in a's frame; name, description and anchor are a's. Keyframes and
/// landmarks that both have bit for bit come once. Others stay as they are: landmarks that two maps
/// have of the same scatterer from different drives are not fused. The frames pass `CheckFrames`.
/// FailedPrecondition where one map's landmarks have elevations or heights and the other's do not,
/// or b lies too far away for a's file.
absl::StatusOr<EditableMap> Merge(const EditableMap& a, const EditableMap& b, MergeCounts& counts);

}  // namespace dcloc
