#include "core/mapping/fix_ties.h"

#include <algorithm>
#include <chrono>
#include <iterator>

namespace dcloc {
namespace {

// The vehicle between two scans, at a steady motion.
Pose2 Between(const TrackedScan& before, const TrackedScan& after, Stamp stamp) {
  const double share = std::chrono::duration<double>(stamp - before.stamp) /
                       std::chrono::duration<double>(after.stamp - before.stamp);
  const Pose2 moved = before.T_odometry_vehicle.Inverse() * after.T_odometry_vehicle;
  return before.T_odometry_vehicle * Exp(Eigen::Vector3d(share * Log(moved)));
}

}  // namespace

std::vector<NodeFix> TieFixes(std::span<const SurveyFix> fixes,
                              const std::vector<std::size_t>& track_of, const SurveyGraph& graph) {
  std::vector<NodeFix> ties;
  for (const SurveyFix& fix : fixes) {
    const auto drive = std::ranges::find(track_of, fix.drive);
    if (drive == track_of.end()) continue;
    const auto index = static_cast<std::size_t>(drive - track_of.begin());
    const DriveTrack& track = graph.track(index);
    const auto scan = std::ranges::lower_bound(track.scans, fix.stamp, {}, &TrackedScan::stamp);
    if (scan == track.scans.end() || scan == track.scans.begin()) continue;
    const auto next = std::ranges::upper_bound(track.nodes, fix.stamp, {}, &SurveyNode::stamp);
    const std::size_t node =
        next == track.nodes.begin() ? 0 : static_cast<std::size_t>(next - track.nodes.begin()) - 1;
    const Pose2 T_node_vehicle =
        track.nodes[node].T_odometry_node.Inverse() * Between(*std::prev(scan), *scan, fix.stamp);
    ties.push_back({.node = graph.NodeAt({index, node}),
                    .p_node = T_node_vehicle.translation_m,
                    .p_map = fix.p_map,
                    .sigma_m = fix.sigma_m});
  }
  return ties;
}

}  // namespace dcloc
