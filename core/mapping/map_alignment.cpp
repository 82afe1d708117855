#include "core/mapping/map_alignment.h"

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/geometry/rigid_fit.h"
#include "core/mapping/drive_track.h"
#include "core/mapping/loop_finder.h"
#include "core/mapping/place_finder.h"
#include "core/mapping/survey_graph.h"

namespace dcloc {
namespace {

/// A map has a tenth of the landmarks that the scans of a survey show, so more of them are joined,
/// and fewer are enough.
constexpr PlaceFinderOptions kOptions{.submap_half_count = 4,
                                      .gate = {.min_inlier_count = 50, .min_overlap = 0.4}};

/// A keyframe as a survey's node. Landmarks are what the keyframe has.
SurveyNode NodeOf(const RadarMap& map, std::size_t index) {
  const Keyframe keyframe = map.keyframe(index);
  SurveyNode node;
  node.T_odometry_node = Flatten(keyframe.T_map_keyframe);
  for (const MapPoint& point : keyframe.points) {
    GaussianPoint<2> landmark;
    landmark.mean_m = {point.x_m, point.y_m};
    landmark.covariance_m2 << point.xx_m2, point.xy_m2, point.xy_m2, point.yy_m2;
    if (map.info().has_heights) landmark.height_square_m2 = std::pow(point.z_m, 2);
    node.centre_m += landmark.mean_m;
    node.landmarks.push_back(landmark);
  }
  if (!node.landmarks.empty()) node.centre_m /= static_cast<double>(node.landmarks.size());
  return node;
}

DriveTrack TrackOf(const RadarMap& map, const std::string& name) {
  DriveTrack track{.name = name};
  for (std::size_t i = 0; i < map.info().keyframe_count; ++i) {
    SurveyNode node = NodeOf(map, i);
    if (!track.nodes.empty()) {
      const SurveyNode& last = track.nodes.back();
      node.motion.pose = last.T_odometry_node.Inverse() * node.T_odometry_node;
      node.motion.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      node.arc_length_m = last.arc_length_m + node.motion.pose.translation_m.norm();
    }
    track.nodes.push_back(std::move(node));
  }
  track.arc_length_m = track.nodes.back().arc_length_m;
  return track;
}

}  // namespace

absl::StatusOr<MapAlignment> AlignMaps(const RadarMap& from, const RadarMap& to,
                                       const std::function<bool(double)>& progress) {
  constexpr std::size_t kTo = 0;
  constexpr std::size_t kFrom = 1;
  const DriveTrack to_track = TrackOf(to, "to");
  const DriveTrack from_track = TrackOf(from, "from");
  const SurveyGraph graph({&to_track, &from_track});
  PlaceFinder finder(kOptions, {});
  bool is_ended = false;
  const auto finding = finder.Find(graph, kFrom, kTo, [&](double share) {
    is_ended = is_ended || !progress(share);
    return !is_ended;
  });
  if (!finding.ok()) return finding.status();
  if (is_ended) return absl::CancelledError("cancelled");
  if (finding->loops.empty()) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "\"%s\" was not found in \"%s\": of %d places %d look like one there, and they do not "
        "agree",
        from.info().name, to.info().name, finding->query_count, finding->match_count));
  }
  std::vector<PlacePair> pairs;
  double height_m = 0.0;
  for (const SurveyEdge& loop : finding->loops) {
    const bool is_forward = graph.IndexOf(loop.from).drive == kTo;
    const auto to_node = graph.IndexOf(is_forward ? loop.from : loop.to);
    const auto from_node = graph.IndexOf(is_forward ? loop.to : loop.from);
    const Pose2 T_node_node = is_forward ? loop.T_from_to.pose : loop.T_from_to.pose.Inverse();
    const Pose3 T_to_node = to.keyframe(to_node.index).T_map_keyframe;
    const Pose3 T_from_node = from.keyframe(from_node.index).T_map_keyframe;
    pairs.push_back(
        {(Flatten(T_to_node) * T_node_node).translation_m, Flatten(T_from_node).translation_m});
    height_m += T_to_node.translation_m.z() - T_from_node.translation_m.z();
  }
  const Pose2 T_to_from = FitRigid(pairs);
  MapAlignment alignment{.T_to_from = Embed(T_to_from), .pair_count = pairs.size()};
  alignment.T_to_from.translation_m.z() = height_m / static_cast<double>(pairs.size());
  for (const PlacePair& pair : pairs) {
    alignment.rms_m += (pair.p_a_m - T_to_from * pair.p_b_m).squaredNorm();
  }
  alignment.rms_m = std::sqrt(alignment.rms_m / static_cast<double>(pairs.size()));
  return alignment;
}

}  // namespace dcloc
