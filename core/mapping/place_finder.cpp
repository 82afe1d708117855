#include "core/mapping/place_finder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/thinning.h"
#include "core/map/keyframe_index.h"
#include "core/map/map_file.h"
#include "core/relocalization/place_search.h"
#include "core/relocalization/view.h"

namespace dcloc {
namespace {

constexpr float kFlatVariance_m2 = 0.01F;  // of a height that is not used

MapPoint ToMapPoint(const GaussianPoint<2>& landmark) {
  const Eigen::Vector2f p = landmark.mean_m.cast<float>();
  const Eigen::Matrix2f c = landmark.covariance_m2.cast<float>();
  return {.x_m = p.x(),
          .y_m = p.y(),
          .z_m = 0.0F,
          .xx_m2 = c(0, 0),
          .xy_m2 = c(0, 1),
          .xz_m2 = 0.0F,
          .yy_m2 = c(1, 1),
          .yz_m2 = 0.0F,
          .zz_m2 = kFlatVariance_m2,
          .rcs_dbsm = 0.0F,
          .scan_count = 1,
          .pass_count = 1};
}

KeyframeRecord ToRecord(const Pose2& T_map_node, std::size_t first_point, std::size_t count) {
  const Pose3 T = Embed(T_map_node);
  return {.translation_local_m = {T.translation_m.x(), T.translation_m.y(), 0.0},
          .rotation_wxyz = {T.rotation.w(), T.rotation.x(), T.rotation.y(), T.rotation.z()},
          .first_point = first_point,
          .point_count = static_cast<std::uint32_t>(count),
          .accuracy = 0};
}

std::vector<std::size_t> NodesOfGroup(const SurveyGraph& graph, std::size_t group) {
  const std::vector<std::size_t> groups = graph.GroupOfDrives();
  std::vector<std::size_t> nodes;
  for (std::size_t drive = 0; drive < graph.drive_count(); ++drive) {
    if (groups[drive] != group) continue;
    for (std::size_t i = 0; i < graph.track(drive).nodes.size(); ++i) {
      nodes.push_back(graph.NodeAt({drive, i}));
    }
  }
  return nodes;
}

}  // namespace

std::span<const OptionField<PlaceFinderOptions>> FieldsOf(const PlaceFinderOptions& /*options*/) {
  using O = PlaceFinderOptions;
  static constexpr OptionField<O> kFields[] = {
      {"query_spacing_m", &O::query_spacing_m, 1, 10'000},
      {"submap_half_count", &O::submap_half_count, 0, 20, "a sub-map is one node"},
      {"search_point_count", &O::search_point_count, 10, 10'000},
      {"candidate_count", &O::candidate_count, 1, 100},
      {"guess_sigma_m", &O::guess_sigma_m, 0.01, 10},
      {"guess_sigma_rad", &O::guess_sigma_rad, 1e-4, 1},
      {"min_agreeing_count", &O::min_agreeing_count, 2, 100},
      {"min_agreeing_path_m", &O::min_agreeing_path_m, 0, 10'000, "sub-maps of one place suffice"},
  };
  return kFields;
}

absl::Status Validate(const PlaceFinderOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("gate", Validate(options.gate)));
  status.Update(Within("consistency", Validate(options.consistency)));
  return status;
}

absl::StatusOr<std::shared_ptr<const RadarMap>> MapOfNodes(const SurveyGraph& graph,
                                                           const std::vector<std::size_t>& nodes) {
  std::vector<KeyframeRecord> keyframes;
  std::vector<MapPoint> points;
  for (const std::size_t node : nodes) {
    const std::vector<GaussianPoint<2>>& landmarks = graph.node(node).landmarks;
    keyframes.push_back(ToRecord(graph.T_map_nodes[node], points.size(), landmarks.size()));
    std::ranges::transform(landmarks, std::back_inserter(points), ToMapPoint);
  }
  InfoRecord info{};
  info.index_cell_m = kIndexCell_m;
  return RadarMap::FromBytes(WriteMapFile({.info = info,
                                           .name = {},
                                           .description = {},
                                           .keyframes = keyframes,
                                           .index = MakeIndex(keyframes, kIndexCell_m),
                                           .points = points}));
}

absl::StatusOr<PlaceFinding> PlaceFinder::Find(const SurveyGraph& graph, std::size_t drive,
                                               std::size_t group,
                                               const std::function<bool(double)>& progress) {
  const std::vector<std::size_t> nodes = NodesOfGroup(graph, group);
  const auto map = MapOfNodes(graph, nodes);
  if (!map.ok()) return map.status();
  const DriveTrack& track = graph.track(drive);
  PlaceFinding finding;
  std::vector<SurveyEdge> matches;
  double next_arc_length_m = 0.0;
  for (std::size_t i = 0; i < track.nodes.size(); ++i) {
    if (track.nodes[i].arc_length_m < next_arc_length_m) continue;
    next_arc_length_m = track.nodes[i].arc_length_m + options_.query_spacing_m;
    const std::size_t node = graph.NodeAt({drive, i});
    const std::vector<GaussianPoint<2>> submap = graph.SubmapOf(node, options_.submap_half_count);
    if (submap.empty()) continue;
    ++finding.query_count;
    PlaceSearch search(*map, PositionsOf<2>(EvenSubsample(submap, options_.search_point_count)),
                       {.max_count = options_.candidate_count});
    while (!search.done()) search.SearchOn();
    for (const PlaceCandidate& place : search.Best()) {
      const auto match = loops_.Register(graph, nodes[place.keyframe], node,
                                         {.T_target_live = place.T_keyframe_vehicle,
                                          .sigma_m = options_.guess_sigma_m,
                                          .sigma_rad = options_.guess_sigma_rad},
                                         options_.gate);
      if (match) matches.push_back(*match);
    }
    finding.match_count = static_cast<int>(matches.size());
    finding.loops = Agreeing(graph, matches);
    const double share = static_cast<double>(i + 1) / static_cast<double>(track.nodes.size());
    if (!progress(share) || !finding.loops.empty()) break;
  }
  return finding;
}

std::vector<SurveyEdge> PlaceFinder::Agreeing(const SurveyGraph& graph,
                                              const std::vector<SurveyEdge>& matches) const {
  const std::vector<Pose2>& T = graph.T_map_nodes;
  const auto agrees = [&](std::size_t a, std::size_t b) {
    const SurveyEdge& one = matches[a];
    const SurveyEdge& other = matches[b];
    if (one.to == other.to) return false;  // one sub-map is at one place
    const double path_length_m =
        std::abs(graph.node(one.to).arc_length_m - graph.node(other.to).arc_length_m);
    const Pose2 T_one_other =
        (T[one.from] * one.T_from_to.pose).Inverse() * T[other.from] * other.T_from_to.pose;
    const Pose2 missed = (T[one.to].Inverse() * T[other.to]).Inverse() * T_one_other;
    return missed.translation_m.norm() <=
               options_.consistency.tolerance_m +
                   options_.consistency.tolerance_share * path_length_m &&
           std::abs(WrapAngle(missed.yaw_rad)) <=
               options_.consistency.tolerance_rad +
                   options_.consistency.tolerance_rad_per_m * path_length_m;
  };
  std::vector<SurveyEdge> agreeing;
  double min_path_m = 1e300;
  double max_path_m = 0.0;
  for (const std::size_t i : ConsistentSet(matches.size(), agrees)) {
    agreeing.push_back(matches[i]);
    min_path_m = std::min(min_path_m, graph.node(matches[i].to).arc_length_m);
    max_path_m = std::max(max_path_m, graph.node(matches[i].to).arc_length_m);
  }
  if (static_cast<int>(agreeing.size()) < options_.min_agreeing_count ||
      max_path_m - min_path_m < options_.min_agreeing_path_m) {
    agreeing.clear();
  }
  return agreeing;
}

}  // namespace dcloc
