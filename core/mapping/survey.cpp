#include "core/mapping/survey.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <set>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/mapping/fix_alignment.h"
#include "core/mapping/fix_ties.h"
#include "core/mapping/survey_graph.h"

namespace dcloc {
namespace {

std::size_t LandmarkCount(const DriveTrack& track) {
  std::size_t count = 0;
  for (const SurveyNode& node : track.nodes) count += node.landmarks.size();
  return count;
}

// Why a drive can be no part of any map; empty where it can.
std::string WhyUseless(const DriveTrack& track, const SurveyOptions& options) {
  if (track.scans.empty()) return "it has no scan";
  if (track.arc_length_m < options.min_path_m) {
    return absl::StrFormat("it moved %.1f m by its ego-motion; at least %g m make a track",
                           track.arc_length_m, options.min_path_m);
  }
  const std::size_t landmark_count = LandmarkCount(track);
  if (landmark_count < options.min_landmark_count) {
    return absl::StrFormat("its scans show %d landmarks; at least %d make a place recognisable",
                           landmark_count, options.min_landmark_count);
  }
  return "";
}

// The survey of drives that are all fit for it, stage by stage.
class Surveyor {
 public:
  Surveyor(std::vector<const DriveTrack*> tracks, const SurveyOptions& options,
           const SurveyProgress& progress, SurveyCheckpointStore* checkpoints)
      : options_(options),
        progress_(progress),
        checkpoints_(checkpoints),
        graph_(std::move(tracks)),
        finder_(options.loops) {}

  absl::Status Run(const std::vector<NodeFix>& fixes) {
    std::vector<std::function<absl::Status()>> stages = {
        [&] { return TieNeighbours(); },
        [&] { return CloseLoops(options_.coarse_stride, "closing loops"); },
        [&] { return JoinDrives(); }, [&] { return PlaceByFixes(fixes); }};
    for (int round = 0; round < options_.refine_rounds; ++round) {
      stages.emplace_back([&] { return CloseLoops(1, "refining"); });
    }
    const std::uint32_t input = checkpoints_ == nullptr ? 0 : InputOf(graph_.tracks(), fixes);
    absl::Status status = GoOn(input);
    for (std::size_t i = finished_stage_count_; i < stages.size() && status.ok(); ++i) {
      status = stages[i]();
      finished_stage_count_ = i + 1;
      if (status.ok()) status = Keep(input);
    }
    return status;
  }

  const SurveyGraph& graph() const { return graph_; }
  const std::vector<Pose2>& T_start_nodes() const { return T_start_nodes_; }
  const std::vector<SurveyEdge>& refused_loops() const { return refused_; }
  std::size_t unconfirmed_count() const { return unconfirmed_count_; }
  std::size_t accepted_fix_count() const { return accepted_fix_count_; }
  const std::string& FindingOf(std::size_t drive) const { return findings_[drive]; }

 private:
  absl::Status Continue(const char* stage, double share) const {
    if (progress_(stage, share)) return absl::OkStatus();
    return absl::CancelledError("the survey was stopped");
  }

  // From the stage after the last one that was kept.
  absl::Status GoOn(std::uint32_t input) {
    if (checkpoints_ == nullptr) return absl::OkStatus();
    const absl::StatusOr<std::vector<std::byte>> bytes = checkpoints_->Read();
    if (!bytes.ok() || bytes->empty()) return bytes.status();
    absl::StatusOr<SurveyCheckpoint> kept =
        CheckpointFromBytes(*bytes, input, graph_.node_count(), graph_.drive_count());
    if (!kept.ok()) {
      const absl::Status& status = kept.status();
      return {status.code(), absl::StrCat(checkpoints_->name(), ": ", status.message())};
    }
    finished_stage_count_ = kept->finished_stage_count;
    graph_.T_map_nodes = std::move(kept->T_map_nodes);
    graph_.neighbours = std::move(kept->neighbours);
    graph_.loops = std::move(kept->loops);
    graph_.fixes = std::move(kept->fixes);
    T_start_nodes_ = std::move(kept->T_start_nodes);
    refused_ = std::move(kept->refused_loops);
    unconfirmed_count_ = kept->unconfirmed_count;
    accepted_fix_count_ = kept->accepted_fix_count;
    findings_ = std::move(kept->findings);
    findings_.resize(graph_.drive_count());
    return absl::OkStatus();
  }

  absl::Status Keep(std::uint32_t input) const {
    if (checkpoints_ == nullptr) return absl::OkStatus();
    return checkpoints_->Write(
        ToBytes({.finished_stage_count = static_cast<std::uint32_t>(finished_stage_count_),
                 .T_map_nodes = graph_.T_map_nodes,
                 .T_start_nodes = T_start_nodes_,
                 .neighbours = graph_.neighbours,
                 .loops = graph_.loops,
                 .refused_loops = refused_,
                 .fixes = graph_.fixes,
                 .unconfirmed_count = unconfirmed_count_,
                 .accepted_fix_count = accepted_fix_count_,
                 .findings = findings_},
                input));
  }

  absl::Status TieNeighbours() {
    for (std::size_t drive = 0; drive < graph_.drive_count(); ++drive) {
      const std::vector<SurveyEdge> edges = finder_.Neighbours(graph_, drive);
      graph_.neighbours.insert(graph_.neighbours.end(), edges.begin(), edges.end());
      const double share =
          static_cast<double>(drive + 1) / static_cast<double>(graph_.drive_count());
      if (absl::Status status = Continue("tying neighbours", share); !status.ok()) return status;
    }
    if (absl::Status status = Solve(); !status.ok()) return status;
    T_start_nodes_ = graph_.T_map_nodes;
    return absl::OkStatus();
  }

  // Places that are passed again, as far as drives are joined.
  absl::Status CloseLoops(std::size_t stride, const char* stage) {
    absl::Status status;
    std::vector<SurveyEdge> found = finder_.NearLoops(graph_, stride, [&](double share) {
      status = Continue(stage, share);
      return status.ok();
    });
    if (!status.ok()) return status;
    found.insert(found.end(), graph_.loops.begin(), graph_.loops.end());
    std::vector<SurveyEdge> confirmed = ConfirmedLoops(found, graph_, options_.consistency);
    unconfirmed_count_ = found.size() - confirmed.size();
    graph_.loops = std::move(confirmed);
    return Solve();
  }

  // Drives that are not joined yet are looked for in the largest group, then in the others.
  absl::Status JoinDrives() {
    findings_.assign(graph_.drive_count(), "");
    bool has_joined = true;
    while (has_joined) {
      has_joined = false;
      for (std::size_t drive = 0; drive < graph_.drive_count(); ++drive) {
        const absl::StatusOr<bool> joined = JoinDrive(drive);
        if (!joined.ok()) return joined.status();
        has_joined = has_joined || *joined;
      }
    }
    return absl::OkStatus();
  }

  // Each group of drives that enough fixes agree with goes into the frame of the fixes.
  absl::Status PlaceByFixes(const std::vector<NodeFix>& fixes) {
    const std::vector<std::size_t> groups = graph_.GroupOfDrives();
    for (std::size_t group = 0; group < graph_.drive_count(); ++group) {
      std::vector<NodeFix> own;
      for (const NodeFix& fix : fixes) {
        if (groups[graph_.IndexOf(fix.node).drive] == group) own.push_back(fix);
      }
      const auto T_map_nodes = AlignWithFixes(graph_.T_map_nodes, own, options_.fix_slack_m);
      if (!T_map_nodes) continue;
      MoveGroup(group, *T_map_nodes);
      graph_.fixes.insert(graph_.fixes.end(), own.begin(), own.end());
    }
    return graph_.fixes.empty() ? absl::OkStatus() : Solve();
  }

  absl::StatusOr<bool> JoinDrive(std::size_t drive) {
    for (const std::size_t group : GroupsBySize()) {
      const std::size_t own = graph_.GroupOfDrives()[drive];
      if (own == group || !tried_.emplace(drive, group, GroupSize(group)).second) continue;
      PlaceFinder places(options_.places, options_.loops);
      absl::Status status;
      const absl::StatusOr<PlaceFinding> found =
          places.Find(graph_, drive, group, [&](double share) {
            status = Continue("joining drives", share);
            return status.ok();
          });
      if (!status.ok()) return status;
      if (!found.ok()) return found.status();
      findings_[drive] =
          absl::StrFormat("%d of its views were searched for, %d matched, too few agree",
                          found->query_count, found->match_count);
      if (found->loops.empty()) continue;
      const SurveyEdge& loop = found->loops.front();
      MoveGroup(own, graph_.T_map_nodes[loop.from] * loop.T_from_to.pose *
                         graph_.T_map_nodes[loop.to].Inverse());
      graph_.loops.insert(graph_.loops.end(), found->loops.begin(), found->loops.end());
      if (absl::Status solved = Solve(); !solved.ok()) return solved;
      return true;
    }
    return false;
  }

  void MoveGroup(std::size_t group, const Pose2& T_new_old) {
    const std::vector<std::size_t> groups = graph_.GroupOfDrives();
    for (std::size_t node = 0; node < graph_.node_count(); ++node) {
      if (groups[graph_.IndexOf(node).drive] != group) continue;
      graph_.T_map_nodes[node] = T_new_old * graph_.T_map_nodes[node];
    }
  }

  std::size_t GroupSize(std::size_t group) const {
    const std::vector<std::size_t> groups = graph_.GroupOfDrives();
    std::size_t size = 0;
    for (std::size_t drive = 0; drive < groups.size(); ++drive) {
      if (groups[drive] == group) size += graph_.track(drive).nodes.size();
    }
    return size;
  }

  std::vector<std::size_t> GroupsBySize() const {
    std::vector<std::size_t> groups = graph_.GroupOfDrives();
    std::ranges::sort(groups);
    groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
    std::ranges::stable_sort(groups, std::greater<>(),
                             [&](std::size_t group) { return GroupSize(group); });
    return groups;
  }

  // Loops that contradict the others are left out for good.
  absl::Status Solve() {
    const auto solution =
        SolveSurveyGraph(graph_.T_map_nodes, graph_.Edges(), graph_.fixes, options_.solver);
    if (!solution.ok()) return solution.status();
    graph_.T_map_nodes = solution->T_map_nodes;
    const std::size_t first_loop = graph_.motions.size() + graph_.neighbours.size();
    std::vector<SurveyEdge> kept;
    for (std::size_t i = 0; i < graph_.loops.size(); ++i) {
      const bool is_accepted = solution->edge_weights[first_loop + i] >= options_.min_weight;
      (is_accepted ? kept : refused_).push_back(graph_.loops[i]);
    }
    graph_.loops = std::move(kept);
    accepted_fix_count_ = static_cast<std::size_t>(std::ranges::count_if(
        solution->fix_weights, [&](double weight) { return weight >= options_.min_weight; }));
    return absl::OkStatus();
  }

  const SurveyOptions& options_;
  const SurveyProgress& progress_;
  SurveyCheckpointStore* const checkpoints_;  // may be null
  std::size_t finished_stage_count_ = 0;
  SurveyGraph graph_;
  LoopFinder finder_;
  std::vector<Pose2> T_start_nodes_;
  std::vector<SurveyEdge> refused_;
  std::size_t unconfirmed_count_ = 0;
  std::size_t accepted_fix_count_ = 0;
  std::vector<std::string> findings_;                                  // by drive
  std::set<std::tuple<std::size_t, std::size_t, std::size_t>> tried_;  // drive, group, its size
};

SurveyLoop Describe(const SurveyEdge& loop, const SurveyGraph& graph,
                    const std::vector<std::size_t>& track_of, bool is_accepted) {
  const SurveyGraph::NodeIndex from = graph.IndexOf(loop.from);
  const SurveyGraph::NodeIndex to = graph.IndexOf(loop.to);
  return {.drive_from = track_of[from.drive],
          .node_from = from.index,
          .drive_to = track_of[to.drive],
          .node_to = to.index,
          .T_from_to = loop.T_from_to.pose,
          .squared_distance = SquaredDistance(loop, graph.T_map_nodes),
          .is_accepted = is_accepted};
}

// For each drive the first one of those that lie in one frame with it: by edges or by fixes.
std::vector<std::size_t> FrameOfDrives(const SurveyGraph& graph) {
  std::vector<std::size_t> frames = graph.GroupOfDrives();
  const std::vector<bool> has_fix = graph.HasFix();
  const auto first = static_cast<std::size_t>(std::ranges::find(has_fix, true) - has_fix.begin());
  for (std::size_t drive = 0; drive < frames.size(); ++drive) {
    if (has_fix[drive]) frames[drive] = frames[first];
  }
  return frames;
}

// The frame in which most was driven.
std::size_t MainFrame(const SurveyGraph& graph, const std::vector<std::size_t>& groups) {
  std::vector<double> driven_m(groups.size(), 0.0);
  for (std::size_t drive = 0; drive < groups.size(); ++drive) {
    driven_m[groups[drive]] += graph.track(drive).arc_length_m;
  }
  return static_cast<std::size_t>(std::ranges::max_element(driven_m) - driven_m.begin());
}

Survey Collect(const Surveyor& surveyor, const std::vector<std::size_t>& track_of,
               std::vector<SurveyedDrive> drives) {
  const SurveyGraph& graph = surveyor.graph();
  const std::vector<std::size_t> frames = FrameOfDrives(graph);
  const std::size_t main_frame = MainFrame(graph, frames);
  std::size_t node = 0;
  for (std::size_t i = 0; i < graph.drive_count(); ++i) {
    SurveyedDrive& drive = drives[track_of[i]];
    drive.T_map_nodes = graph.PosesOf(i);
    const auto count = static_cast<std::ptrdiff_t>(drive.T_map_nodes.size());
    const auto begin = surveyor.T_start_nodes().begin() + static_cast<std::ptrdiff_t>(node);
    drive.T_start_nodes.assign(begin, begin + count);
    node += static_cast<std::size_t>(count);
    drive.is_in_map = frames[i] == main_frame;
    if (!drive.is_in_map) {
      drive.reason = absl::StrCat("it shares no ground with the others: ", surveyor.FindingOf(i));
    }
  }
  for (const SurveyEdge& edge : graph.neighbours) {
    ++drives[track_of[graph.IndexOf(edge.from).drive]].neighbour_count;
  }
  Survey survey{.drives = std::move(drives),
                .loops = {},
                .unconfirmed_loop_count = surveyor.unconfirmed_count()};
  for (const SurveyEdge& loop : graph.loops) {
    survey.loops.push_back(Describe(loop, graph, track_of, true));
  }
  for (const SurveyEdge& loop : surveyor.refused_loops()) {
    survey.loops.push_back(Describe(loop, graph, track_of, false));
  }
  return survey;
}

}  // namespace

std::span<const OptionField<SurveyOptions>> FieldsOf(const SurveyOptions& /*options*/) {
  using O = SurveyOptions;
  static constexpr OptionField<O> kFields[] = {
      {"refine_rounds", &O::refine_rounds, 0, 100, "loops are looked for once"},
      {"coarse_stride", &O::coarse_stride, 1, 1000},
      {"min_path_m", &O::min_path_m, 1, 10'000},
      {"min_landmark_count", &O::min_landmark_count, 1, 1e9},
      {"min_weight", &O::min_weight, 0.01, 0.99},
      {"fix_slack_m", &O::fix_slack_m, 0, 100, "drives are not bent"},
  };
  return kFields;
}

absl::Status Validate(const SurveyOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("loops", Validate(options.loops)));
  status.Update(Within("consistency", Validate(options.consistency)));
  status.Update(Within("places", Validate(options.places)));
  status.Update(Within("solver", Validate(options.solver)));
  return status;
}

absl::StatusOr<Survey> SurveyDrives(std::span<const DriveTrack> tracks,
                                    std::span<const SurveyFix> fixes, const SurveyOptions& options,
                                    const SurveyProgress& progress,
                                    SurveyCheckpointStore* checkpoints) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  std::vector<SurveyedDrive> drives;
  std::vector<std::size_t> track_of;  // of each drive that is fit
  std::vector<const DriveTrack*> fit;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    drives.push_back({.name = tracks[i].name, .reason = WhyUseless(tracks[i], options)});
    if (!drives.back().reason.empty()) continue;
    track_of.push_back(i);
    fit.push_back(&tracks[i]);
  }
  if (fit.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("no drive can be surveyed: ",
                     absl::StrJoin(drives, "; ", [](std::string* text, const SurveyedDrive& drive) {
                       absl::StrAppend(text, drive.name, ": ", drive.reason);
                     })));
  }
  Surveyor surveyor(std::move(fit), options, progress, checkpoints);
  const std::vector<NodeFix> ties = TieFixes(fixes, track_of, surveyor.graph());
  if (absl::Status status = surveyor.Run(ties); !status.ok()) return status;
  Survey survey = Collect(surveyor, track_of, std::move(drives));
  survey.fix_count = ties.size();
  survey.accepted_fix_count = surveyor.accepted_fix_count();
  return survey;
}

}  // namespace dcloc
