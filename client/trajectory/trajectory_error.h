#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <vector>

#include "client/trajectory/trajectory.h"
#include "core/geometry/pose.h"

namespace dcloc {

/// A pose of a trajectory and where the vehicle really was.
struct TrajectoryPair {
  Pose3 T_map_vehicle;
  Pose3 T_truth_vehicle;
  Stamp stamp{};  ///< of pairs that were found by it
};

/// The poses of `trajectory` beside those of `reference`, which is interpolated between its poses.
/// Stamps outside of the reference, or in a gap of it longer than `max_gap`, give no pair.
std::vector<TrajectoryPair> PairByStamp(const Trajectory& trajectory, const Trajectory& reference,
                                        std::chrono::nanoseconds max_gap = std::chrono::seconds(1));

/// The pose of the map in the frame of the truth, in the plane, that brings positions nearest to it
/// in the least squares sense (Umeyama without scale). The identity for fewer than two pairs.
Pose2 AlignTrajectory(std::span<const TrajectoryPair> pairs);

/// How far one pose is off, once aligned by `T_truth_map`.
struct PoseOffset {
  double position_m = 0.0;   ///< distance in space
  double heading_deg = 0.0;  ///< of the x axis in the plane, without sign
};
PoseOffset OffsetOf(const TrajectoryPair& pair, const Pose2& T_truth_map = {});

struct TrajectoryError {
  double rmse_m = 0.0;  ///< of positions, once aligned
  double max_m = 0.0;
  double rmse_deg = 0.0;  ///< of headings, likewise
};

/// Of pairs that are aligned with one another by `T_truth_map`.
TrajectoryError ErrorOf(std::span<const TrajectoryPair> pairs, const Pose2& T_truth_map);

/// How fast a trajectory goes wrong: means over all segments of `length_m` along the path (as the
/// KITTI odometry benchmark does).
struct TrajectoryDrift {
  double translation_percent = 0.0;
  double rotation_deg_per_100m = 0.0;
  std::size_t segment_count = 0;
};
TrajectoryDrift DriftOver(std::span<const TrajectoryPair> pairs, double length_m);

}  // namespace dcloc
