#include "client/landmarks/keyframe_trajectory.h"

#include <chrono>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

constexpr double kShifted_m = 1e-6;
constexpr double kTurned_rad = 1e-6;

Stamp StampOf(std::size_t keyframe) { return Stamp(std::chrono::seconds(keyframe)); }

Pose3 PoseInMap(const EditableMap& map, const KeyframeRecord& record) {
  Pose3 pose = PoseOf(record);
  pose.translation_m += map.Origin_m();
  return pose;
}

}  // namespace

Trajectory KeyframeTrajectory(const EditableMap& map) {
  Trajectory trajectory{.name = map.name, .anchor = map.Anchor(), .poses = {}};
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    trajectory.poses.push_back({StampOf(i), PoseInMap(map, map.keyframes[i].record)});
  }
  return trajectory;
}

absl::StatusOr<EditableMap> MoveKeyframes(const EditableMap& base, const Trajectory& trajectory,
                                          std::size_t& moved_count) {
  if (trajectory.poses.size() != base.keyframes.size()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s: has %d poses; it must have one for each of the %d keyframes",
                        trajectory.name, trajectory.poses.size(), base.keyframes.size()));
  }
  moved_count = 0;
  EditableMap moved = base;
  for (std::size_t i = 0; i < moved.keyframes.size(); ++i) {
    const auto& [stamp, T_map_keyframe] = trajectory.poses[i];
    if (stamp != StampOf(i)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "%s: the stamp of pose %d is %d ns; it must be %d s, the number of its keyframe",
          trajectory.name, i, stamp.time_since_epoch().count(), i));
    }
    KeyframeRecord& record = moved.keyframes[i].record;
    const Pose3 change = PoseInMap(base, record).Inverse() * T_map_keyframe;
    if (change.translation_m.norm() < kShifted_m && RotationAngle(change) < kTurned_rad) continue;
    const Eigen::Vector3d t = T_map_keyframe.translation_m - base.Origin_m();
    const Eigen::Quaterniond q = T_map_keyframe.rotation.normalized();
    record.translation_local_m = {t.x(), t.y(), t.z()};
    record.rotation_wxyz = {q.w(), q.x(), q.y(), q.z()};
    ++moved_count;
  }
  return moved;
}

}  // namespace dcloc
