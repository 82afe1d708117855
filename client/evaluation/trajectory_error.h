#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/pose.h"

namespace dcloc {

/// A pose of a trajectory and where the vehicle really was.
struct TrajectoryPair {
  Pose2 T_map_vehicle;
  Pose2 T_truth_vehicle;
};

/// The pose of the map in the frame of the truth that brings positions nearest to it in the least
/// squares sense (Umeyama without scale). The identity for fewer than two pairs.
Pose2 AlignTrajectory(std::span<const TrajectoryPair> pairs);

struct TrajectoryError {
  double rmse_m = 0.0;  ///< of positions, once aligned
  double max_m = 0.0;
  double rmse_deg = 0.0;  ///< of headings, likewise
};

/// Of pairs that are aligned with one another by `T_truth_map`.
TrajectoryError ErrorOf(std::span<const TrajectoryPair> pairs, const Pose2& T_truth_map);

/// How fast a trajectory goes wrong: means over all stretches of `length_m` of way (as the KITTI
/// odometry benchmark does).
struct TrajectoryDrift {
  double translation_percent = 0.0;
  double rotation_deg_per_100m = 0.0;
  std::size_t stretch_count = 0;
};
TrajectoryDrift DriftOver(std::span<const TrajectoryPair> pairs, double length_m);

}  // namespace dcloc
