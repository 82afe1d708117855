#include "client/trajectory/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

std::optional<Pose3> PoseAt(const std::vector<TrajectoryPose>& poses, Stamp stamp,
                            std::chrono::nanoseconds max_gap) {
  const auto after = std::ranges::lower_bound(poses, stamp, {}, &TrajectoryPose::stamp);
  if (after == poses.end()) return std::nullopt;
  if (after->stamp == stamp) return after->T_map_vehicle;
  if (after == poses.begin()) return std::nullopt;
  const TrajectoryPose& before = *std::prev(after);
  const std::chrono::nanoseconds gap = after->stamp - before.stamp;
  if (gap > max_gap) return std::nullopt;
  const double share =
      static_cast<double>((stamp - before.stamp).count()) / static_cast<double>(gap.count());
  const Vector6d step = Log(before.T_map_vehicle.Inverse() * after->T_map_vehicle);
  return before.T_map_vehicle * Exp(Vector6d(share * step));
}

}  // namespace

std::vector<StampedError> ErrorsAgainst(const Trajectory& trajectory, const Trajectory& reference,
                                        std::chrono::nanoseconds max_gap) {
  std::vector<StampedError> errors;
  errors.reserve(trajectory.poses.size());
  for (const auto& [stamp, pose] : trajectory.poses) {
    const std::optional<Pose3> truth = PoseAt(reference.poses, stamp, max_gap);
    if (!truth) continue;
    errors.push_back({stamp, (pose.translation_m - truth->translation_m).norm(),
                      std::abs(WrapAngle(Yaw(pose.rotation) - Yaw(truth->rotation))) * kDegPerRad});
  }
  return errors;
}

}  // namespace dcloc
