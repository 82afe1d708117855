#include "core/mapping/survey_graph.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <span>
#include <utility>

namespace dcloc {

std::span<const OptionField<PathCosts>> FieldsOf(const PathCosts& /*options*/) {
  using O = PathCosts;
  static constexpr OptionField<O> kFields[] = {
      {"loop_m", &O::loop_m, 0, 10'000, "a loop joins nodes as if they were one"},
      {"path_m_per_fix_sigma", &O::path_m_per_fix_sigma, 0, 1e6,
       "fixes join nodes as if they were one"},
  };
  return kFields;
}

absl::Status Validate(const PathCosts& options) {
  return ValidateFields(options, FieldsOf(options));
}

SurveyGraph::SurveyGraph(std::vector<const DriveTrack*> tracks) : tracks_(std::move(tracks)) {
  for (const DriveTrack* const each : tracks_) {
    const DriveTrack& track = *each;
    first_node_.push_back(T_map_nodes.size());
    const Pose2 T_map_odometry = track.nodes.front().T_odometry_node.Inverse();
    for (std::size_t i = 0; i < track.nodes.size(); ++i) {
      if (i > 0) {
        motions.push_back({.from = T_map_nodes.size() - 1,
                           .to = T_map_nodes.size(),
                           .T_from_to = track.nodes[i].motion,
                           .is_certain = true});
      }
      T_map_nodes.push_back(T_map_odometry * track.nodes[i].T_odometry_node);
    }
  }
  first_node_.push_back(T_map_nodes.size());
}

SurveyGraph::NodeIndex SurveyGraph::IndexOf(std::size_t node) const {
  const auto after = std::ranges::upper_bound(first_node_, node);
  const auto drive = static_cast<std::size_t>(after - first_node_.begin()) - 1;
  return {drive, node - first_node_[drive]};
}

const SurveyNode& SurveyGraph::node(std::size_t node) const {
  const NodeIndex at = IndexOf(node);
  return track(at.drive).nodes[at.index];
}

std::vector<Pose2> SurveyGraph::PosesOf(std::size_t drive) const {
  return {T_map_nodes.begin() + static_cast<std::ptrdiff_t>(first_node_[drive]),
          T_map_nodes.begin() + static_cast<std::ptrdiff_t>(first_node_[drive + 1])};
}

Eigen::Vector2d SurveyGraph::CentreOf(std::size_t node) const {
  return T_map_nodes[node] * this->node(node).centre_m;
}

std::vector<GaussianPoint<2>> SurveyGraph::SubmapOf(std::size_t node,
                                                    std::size_t half_count) const {
  const NodeIndex at = IndexOf(node);
  const std::size_t begin = first_node_[at.drive];
  const std::size_t count = first_node_[at.drive + 1] - begin;
  return JoinSubmap(track(at.drive), std::span(T_map_nodes).subspan(begin, count), at.index,
                    half_count);
}

std::vector<SurveyEdge> SurveyGraph::Edges() const {
  std::vector<SurveyEdge> edges = motions;
  edges.insert(edges.end(), neighbours.begin(), neighbours.end());
  edges.insert(edges.end(), loops.begin(), loops.end());
  return edges;
}

std::vector<std::size_t> SurveyGraph::GroupOfDrives() const {
  const std::vector<std::size_t> part_of = PartsOf(node_count(), Edges());
  std::vector<std::size_t> groups;
  for (std::size_t drive = 0; drive < drive_count(); ++drive) {
    groups.push_back(IndexOf(part_of[first_node_[drive]]).drive);
  }
  return groups;
}

std::vector<bool> SurveyGraph::HasFix() const {
  const std::vector<std::size_t> groups = GroupOfDrives();
  std::vector<bool> group_has_fix(drive_count(), false);
  for (const NodeFix& fix : fixes) group_has_fix[groups[IndexOf(fix.node).drive]] = true;
  std::vector<bool> has_fix;
  has_fix.reserve(groups.size());
  for (const std::size_t group : groups) has_fix.push_back(group_has_fix[group]);
  return has_fix;
}

namespace {

// The other ends of each node's loops.
std::vector<std::vector<std::size_t>> LoopEnds(std::span<const SurveyEdge> loops,
                                               std::size_t node_count) {
  std::vector<std::vector<std::size_t>> ends(node_count);
  for (const SurveyEdge& loop : loops) {
    ends[loop.from].push_back(loop.to);
    ends[loop.to].push_back(loop.from);
  }
  return ends;
}

// The length of the shortest edge from each node to the frame of the fixes.
std::vector<double> ToFixes(std::span<const NodeFix> fixes, std::size_t node_count,
                            const PathCosts& costs) {
  std::vector<double> to_fixes_m(node_count, std::numeric_limits<double>::infinity());
  for (const NodeFix& fix : fixes) {
    to_fixes_m[fix.node] = std::min(to_fixes_m[fix.node], costs.path_m_per_fix_sigma * fix.sigma_m);
  }
  return to_fixes_m;
}

}  // namespace

std::vector<std::pair<std::size_t, double>> SurveyGraph::PathsFrom(std::size_t from, double limit_m,
                                                                   const PathCosts& costs) const {
  // The edges along a drive need no list.
  const std::vector<std::vector<std::size_t>> across = LoopEnds(loops, node_count());
  // The fixes' frame is one more node.
  const std::size_t hub = node_count();
  const std::vector<double> to_hub_m = ToFixes(fixes, node_count(), costs);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::vector<double> shortest_m(node_count() + 1, std::numeric_limits<double>::infinity());
  std::vector<std::pair<std::size_t, double>> reached;
  const auto reach = [&](std::size_t node, double path_length_m) {
    if (path_length_m > limit_m || path_length_m >= shortest_m[node]) return;
    shortest_m[node] = path_length_m;
    open.emplace(path_length_m, node);
  };
  reach(from, 0.0);
  while (!open.empty()) {
    const auto [path_length_m, here] = open.top();
    open.pop();
    if (path_length_m > shortest_m[here]) continue;
    if (here == hub) {
      for (const NodeFix& fix : fixes) reach(fix.node, path_length_m + to_hub_m[fix.node]);
      continue;
    }
    reached.emplace_back(here, path_length_m);
    reach(hub, path_length_m + to_hub_m[here]);
    const NodeIndex at = IndexOf(here);
    const std::vector<SurveyNode>& nodes = track(at.drive).nodes;
    if (at.index > 0) {
      reach(here - 1,
            path_length_m + nodes[at.index].arc_length_m - nodes[at.index - 1].arc_length_m);
    }
    if (at.index + 1 < nodes.size()) {
      reach(here + 1,
            path_length_m + nodes[at.index + 1].arc_length_m - nodes[at.index].arc_length_m);
    }
    for (const std::size_t there : across[here]) reach(there, path_length_m + costs.loop_m);
  }
  return reached;
}

}  // namespace dcloc
