#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/pose_estimate.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// A few metres of a drive: a vehicle pose, and the landmarks that the scans around it show. The
/// survey places drives node by node.
struct SurveyNode {
  Stamp stamp;
  Pose2 T_odometry_node;      ///< by ego-motion alone, from the drive's first scan
  PoseEstimate<2> motion;     ///< T_previous_node by ego-motion; of the first node it means nothing
  double arc_length_m = 0.0;  ///< driven since the first scan
  std::vector<GaussianPoint<2>> landmarks;             ///< in the node's frame
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();  ///< mean of the landmarks, likewise
};

/// A scan of a drive, by the node beside it.
struct TrackedScan {
  Stamp stamp;
  Pose2 T_odometry_vehicle;
};

/// What a radar of a drive saw.
struct RadarTally {
  std::string radar_id;
  std::size_t scan_count = 0;
  std::size_t target_count = 0;
  std::size_t static_count = 0;  ///< targets whose range rate fits the ego-motion
};

/// A drive as the survey sees it: its trajectory by ego-motion and its nodes.
struct DriveTrack {
  std::string name;
  std::vector<SurveyNode> nodes;   ///< in the order of the drive
  std::vector<TrackedScan> scans;  ///< one for each scan of the drive, by ascending stamp
  std::vector<RadarTally> radars;
  double arc_length_m = 0.0;  ///< driven from the first scan to the last
};

/// The pose of a scan where the survey has placed the nodes at `T_map_nodes`: ego-motion from the
/// node before it; what that misses to the node after it is spread over the scans between the two.
/// `track` has a node, and as many as `T_map_nodes`.
Pose2 PlaceScan(const DriveTrack& track, std::span<const Pose2> T_map_nodes,
                const TrackedScan& scan);

/// The landmarks of the nodes `centre` - `half_count` to `centre` + `half_count` of a drive, in the
/// frame of the node `centre`, nodes lying at `T_map_nodes`.
std::vector<GaussianPoint<2>> JoinSubmap(const DriveTrack& track,
                                         std::span<const Pose2> T_map_nodes, std::size_t centre,
                                         std::size_t half_count);

}  // namespace dcloc
