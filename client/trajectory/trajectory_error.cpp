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

std::vector<TrajectoryPair> PairByStamp(const Trajectory& trajectory, const Trajectory& reference,
                                        std::chrono::nanoseconds max_gap) {
  std::vector<TrajectoryPair> pairs;
  pairs.reserve(trajectory.poses.size());
  for (const auto& [stamp, pose] : trajectory.poses) {
    const std::optional<Pose3> truth = PoseAt(reference.poses, stamp, max_gap);
    if (truth) pairs.push_back({pose, *truth, stamp});
  }
  return pairs;
}

Pose2 AlignTrajectory(std::span<const TrajectoryPair> pairs) {
  if (pairs.size() < 2) return {};
  Eigen::Vector2d mean_map = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_truth = Eigen::Vector2d::Zero();
  for (const TrajectoryPair& pair : pairs) {
    mean_map += pair.T_map_vehicle.translation_m.head<2>();
    mean_truth += pair.T_truth_vehicle.translation_m.head<2>();
  }
  mean_map /= static_cast<double>(pairs.size());
  mean_truth /= static_cast<double>(pairs.size());
  double along = 0.0;
  double across = 0.0;
  for (const TrajectoryPair& pair : pairs) {
    const Eigen::Vector2d a = pair.T_map_vehicle.translation_m.head<2>() - mean_map;
    const Eigen::Vector2d b = pair.T_truth_vehicle.translation_m.head<2>() - mean_truth;
    along += a.dot(b);
    across += a.x() * b.y() - a.y() * b.x();
  }
  Pose2 T_truth_map{.yaw_rad = std::atan2(across, along)};
  T_truth_map.translation_m = mean_truth - T_truth_map.Rotation() * mean_map;
  return T_truth_map;
}

PoseOffset OffsetOf(const TrajectoryPair& pair, const Pose2& T_truth_map) {
  const Pose3 aligned = Embed(T_truth_map) * pair.T_map_vehicle;
  const double turn_rad = Yaw(aligned.rotation) - Yaw(pair.T_truth_vehicle.rotation);
  return {.position_m = (aligned.translation_m - pair.T_truth_vehicle.translation_m).norm(),
          .heading_deg = std::abs(WrapAngle(turn_rad)) * kDegPerRad};
}

TrajectoryError ErrorOf(std::span<const TrajectoryPair> pairs, const Pose2& T_truth_map) {
  TrajectoryError error;
  for (const TrajectoryPair& pair : pairs) {
    const PoseOffset off = OffsetOf(pair, T_truth_map);
    error.rmse_m += off.position_m * off.position_m;
    error.max_m = std::max(error.max_m, off.position_m);
    error.rmse_deg += off.heading_deg * off.heading_deg;
  }
  const double count = std::max<double>(1.0, static_cast<double>(pairs.size()));
  error.rmse_m = std::sqrt(error.rmse_m / count);
  error.rmse_deg = std::sqrt(error.rmse_deg / count);
  return error;
}

TrajectoryDrift DriftOver(std::span<const TrajectoryPair> pairs, double length_m) {
  std::vector<double> way_m(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    way_m[i] = way_m[i - 1] +
               (pairs[i].T_truth_vehicle.translation_m - pairs[i - 1].T_truth_vehicle.translation_m)
                   .norm();
  }
  TrajectoryDrift drift;
  std::size_t end = 0;
  for (std::size_t begin = 0; begin < pairs.size(); ++begin) {
    while (end < pairs.size() && way_m[end] < way_m[begin] + length_m) ++end;
    if (end == pairs.size()) break;
    const double length = way_m[end] - way_m[begin];
    const Pose3 truth = pairs[begin].T_truth_vehicle.Inverse() * pairs[end].T_truth_vehicle;
    const Pose3 moved = pairs[begin].T_map_vehicle.Inverse() * pairs[end].T_map_vehicle;
    const Pose3 off = truth.Inverse() * moved;
    drift.translation_percent += 100.0 * off.translation_m.norm() / length;
    drift.rotation_deg_per_100m += 100.0 * std::abs(Yaw(off.rotation)) * kDegPerRad / length;
    ++drift.segment_count;
  }
  if (drift.segment_count > 0) {
    drift.translation_percent /= static_cast<double>(drift.segment_count);
    drift.rotation_deg_per_100m /= static_cast<double>(drift.segment_count);
  }
  return drift;
}

}  // namespace dcloc
