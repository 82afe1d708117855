#include "core/mapping/drive_track.h"

#include <algorithm>

namespace dcloc {

Pose2 PlaceScan(const DriveTrack& track, std::span<const Pose2> T_map_nodes,
                const TrackedScan& scan) {
  const auto after = std::ranges::upper_bound(track.nodes, scan.stamp, {}, &SurveyNode::stamp);
  const auto next = static_cast<std::size_t>(after - track.nodes.begin());
  const std::size_t here = next == 0 ? 0 : next - 1;
  const SurveyNode& node = track.nodes[here];
  const Pose2 T_node_vehicle = node.T_odometry_node.Inverse() * scan.T_odometry_vehicle;
  if (next == 0 || next == track.nodes.size()) return T_map_nodes[here] * T_node_vehicle;

  const SurveyNode& next_node = track.nodes[next];
  const Pose2 T_node_next = node.T_odometry_node.Inverse() * next_node.T_odometry_node;
  const Pose2 missed = (T_map_nodes[here] * T_node_next).Inverse() * T_map_nodes[next];
  const double share = std::chrono::duration<double>(scan.stamp - node.stamp) /
                       std::chrono::duration<double>(next_node.stamp - node.stamp);
  return T_map_nodes[here] * T_node_vehicle * Exp(Eigen::Vector3d(share * Log(missed)));
}

std::vector<GaussianPoint<2>> JoinSubmap(const DriveTrack& track,
                                         std::span<const Pose2> T_map_nodes, std::size_t centre,
                                         std::size_t half_count) {
  const std::size_t begin = centre - std::min(centre, half_count);
  const std::size_t end = std::min(track.nodes.size(), centre + half_count + 1);
  const Pose2 T_centre_map = T_map_nodes[centre].Inverse();
  std::vector<GaussianPoint<2>> points;
  for (std::size_t i = begin; i < end; ++i) {
    const Pose2 T_centre_node = T_centre_map * T_map_nodes[i];
    const Eigen::Matrix2d rotation = T_centre_node.Rotation();
    for (const GaussianPoint<2>& landmark : track.nodes[i].landmarks) {
      points.push_back({.mean_m = T_centre_node * landmark.mean_m,
                        .covariance_m2 = rotation * landmark.covariance_m2 * rotation.transpose()});
    }
  }
  return points;
}

}  // namespace dcloc
