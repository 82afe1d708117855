#include "core/mapping/loop_finder.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace dcloc {

std::span<const OptionField<LoopFinderOptions>> FieldsOf(const LoopFinderOptions& /*options*/) {
  using O = LoopFinderOptions;
  static constexpr OptionField<O> kFields[] = {
      {"neighbour_count", &O::neighbour_count, 0, 100, "nodes are tied by ego-motion alone"},
      {"min_loop_path_m", &O::min_loop_path_m, 1, 10'000},
      {"near_m", &O::near_m, 0.1, 200},
      {"max_visit_count", &O::max_visit_count, 1, 100'000},
      {"base_sigma_m", &O::base_sigma_m, 1e-3, 10},
      {"base_sigma_rad", &O::base_sigma_rad, 1e-5, 1},
      {"drift_share", &O::drift_share, 1e-5, 1},
      {"drift_rad_per_m", &O::drift_rad_per_m, 1e-7, 0.1},
      {"max_sigma_m", &O::max_sigma_m, 0.1, 100},
      {"search_sigmas", &O::search_sigmas, 0.5, 10},
      {"submap_half_count", &O::submap_half_count, 0, 20, "a sub-map is one node"},
  };
  return kFields;
}

absl::Status Validate(const LoopFinderOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("matcher", Validate(options.matcher)));
  status.Update(Within("path_costs", Validate(options.path_costs)));
  status.Update(Within("neighbour_gate", Validate(options.neighbour_gate)));
  status.Update(Within("loop_gate", Validate(options.loop_gate)));
  return status;
}

std::vector<SurveyEdge> LoopFinder::Neighbours(const SurveyGraph& graph, std::size_t drive) {
  const std::vector<SurveyNode>& nodes = graph.track(drive).nodes;
  std::vector<LocalMap<2>> targets;
  std::vector<SurveyEdge> edges;
  const auto reach = static_cast<std::size_t>(options_.neighbour_count);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t begin = i - std::min(i, reach);
    for (std::size_t k = begin; k < i; ++k) {
      const std::size_t from = graph.NodeAt({drive, k});
      const std::size_t to = graph.NodeAt({drive, i});
      const double path_length_m = nodes[i].arc_length_m - nodes[k].arc_length_m;
      const SubmapGuess guess{
          .T_target_live = graph.T_map_nodes[from].Inverse() * graph.T_map_nodes[to],
          .sigma_m = SigmaAfter(path_length_m),
          .sigma_rad = options_.base_sigma_rad + options_.drift_rad_per_m * path_length_m};
      const std::optional<SubmapMatch> match = matcher_.Match(
          nodes[i].landmarks, targets[k % (reach + 1)], guess, options_.neighbour_gate);
      if (match) edges.push_back({.from = from, .to = to, .T_from_to = match->T_target_live});
    }
    if (targets.size() <= reach) targets.emplace_back();
    targets[i % (reach + 1)] = LocalMap<2>(Pose3{}, nodes[i].landmarks);
  }
  return edges;
}

std::optional<SurveyEdge> LoopFinder::Register(const SurveyGraph& graph, std::size_t from,
                                               std::size_t to, const SubmapGuess& guess,
                                               const RegistrationGate& gate) {
  // As far as the search may move the sub-map, the target has ground beneath it.
  const DriveTrack& track = graph.track(graph.IndexOf(from).drive);
  const double spacing_m =
      std::max(1.0, track.arc_length_m / static_cast<double>(track.nodes.size()));
  const auto wider =
      static_cast<std::size_t>(std::ceil(options_.search_sigmas * guess.sigma_m / spacing_m));
  // A sub-map of more nodes is bent by the ego-motion within it.
  constexpr std::size_t kMaxWider = 4;
  const LocalMap<2> target(
      Pose3{}, graph.SubmapOf(from, options_.submap_half_count + 1 + std::min(wider, kMaxWider)));
  const std::optional<SubmapMatch> match =
      matcher_.Match(graph.SubmapOf(to, options_.submap_half_count), target, guess, gate);
  if (!match) return std::nullopt;
  return SurveyEdge{.from = from, .to = to, .T_from_to = match->T_target_live};
}

std::vector<SurveyEdge> LoopFinder::NearLoops(const SurveyGraph& graph, std::size_t stride,
                                              const std::function<bool(double)>& progress) {
  std::set<std::pair<std::size_t, std::size_t>> known;
  for (const SurveyEdge& loop : graph.loops) known.emplace(loop.from, loop.to);
  std::vector<SurveyEdge> found;
  for (std::size_t node = 0; node < graph.node_count(); node += stride) {
    for (const Visit& visit : SomeOf(VisitsNear(graph, node), node)) {
      if (known.contains({visit.node, node})) continue;
      const SubmapGuess guess{
          .T_target_live = graph.T_map_nodes[visit.node].Inverse() * graph.T_map_nodes[node],
          .sigma_m = SigmaAfter(visit.path_length_m),
          .sigma_rad = options_.base_sigma_rad + options_.drift_rad_per_m * visit.path_length_m};
      const auto loop = Register(graph, visit.node, node, guess, options_.loop_gate);
      if (loop) found.push_back(*loop);
    }
    if (!progress(static_cast<double>(node + 1) / static_cast<double>(graph.node_count()))) break;
  }
  return found;
}

// Of the nodes before `node` in the row, those that are nearest to it each time a drive passes.
std::vector<LoopFinder::Visit> LoopFinder::VisitsNear(const SurveyGraph& graph,
                                                      std::size_t node) const {
  const double limit_m = (options_.max_sigma_m - options_.base_sigma_m) / options_.drift_share;
  std::vector<Visit> near;
  const SurveyGraph::NodeIndex here = graph.IndexOf(node);
  for (const auto& [other, path_length_m] : graph.PathsFrom(node, limit_m, options_.path_costs)) {
    if (other >= node) continue;
    if (graph.IndexOf(other).drive == here.drive &&
        graph.node(node).arc_length_m - graph.node(other).arc_length_m < options_.min_loop_path_m) {
      continue;
    }
    const double distance_m = (graph.CentreOf(node) - graph.CentreOf(other)).norm();
    if (distance_m <= options_.near_m + options_.search_sigmas * SigmaAfter(path_length_m)) {
      near.push_back({other, path_length_m, distance_m});
    }
  }
  std::ranges::sort(near, {}, &Visit::node);
  std::vector<Visit> visits;
  std::size_t previous = 0;
  for (const Visit& visit : near) {
    const bool goes_on = !visits.empty() && visit.node - previous <= 2 &&
                         graph.IndexOf(visits.back().node).drive == graph.IndexOf(visit.node).drive;
    if (!goes_on) {
      visits.push_back(visit);
    } else if (visit.distance_m < visits.back().distance_m) {
      visits.back() = visit;
    }
    previous = visit.node;
  }
  return visits;
}

// Evenly spread over the row. Nodes that follow one another take the same passes, since loops are
// confirmed by those beside them; others take other ones.
std::vector<LoopFinder::Visit> LoopFinder::SomeOf(const std::vector<Visit>& visits,
                                                  std::size_t node) const {
  constexpr std::size_t kNodesAlike = 16;
  const auto max_count = static_cast<std::size_t>(options_.max_visit_count);
  if (visits.size() <= max_count) return visits;
  std::vector<Visit> some;
  for (std::size_t i = 0; i < max_count; ++i) {
    some.push_back(visits[(node / kNodesAlike + i * visits.size() / max_count) % visits.size()]);
  }
  return some;
}

}  // namespace dcloc
