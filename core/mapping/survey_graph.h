#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/mapping/drive_track.h"
#include "core/mapping/survey_graph_solver.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// What joins two nodes otherwise than by driving from one to the other, as the length of path over
/// which ego-motion becomes as uncertain.
struct PathCosts {
  double loop_m = 10.0;  ///< a registration of the two: about 0.1 m
  /// Two fixes, for each metre of their deviations: as if ego-motion drifted by a hundredth.
  double path_m_per_fix_sigma = 100.0;
};
std::span<const OptionField<PathCosts>> FieldsOf(const PathCosts& options);
absl::Status Validate(const PathCosts& options);

/// The nodes of all drives, numbered in one row, with what is known of how they lie to one another.
/// Drives that nothing joins lie in frames of their own.
class SurveyGraph {
 public:
  /// The nodes where ego-motion puts them, each drive from the identity. The tracks outlive
  /// this; each has a node.
  explicit SurveyGraph(std::vector<const DriveTrack*> tracks);

  /// A node by its drive and its index there.
  struct NodeIndex {
    std::size_t drive;
    std::size_t index;
  };
  NodeIndex IndexOf(std::size_t node) const;
  std::size_t NodeAt(const NodeIndex& at) const { return first_node_[at.drive] + at.index; }
  const SurveyNode& node(std::size_t node) const;
  std::size_t node_count() const { return T_map_nodes.size(); }
  std::size_t drive_count() const { return tracks_.size(); }
  const DriveTrack& track(std::size_t drive) const { return *tracks_[drive]; }
  std::span<const DriveTrack* const> tracks() const { return tracks_; }

  /// Poses of one drive's nodes.
  std::vector<Pose2> PosesOf(std::size_t drive) const;

  /// Middle of what a node shows, in the map.
  Eigen::Vector2d CentreOf(std::size_t node) const;

  /// The landmarks around a node, in its frame.
  std::vector<GaussianPoint<2>> SubmapOf(std::size_t node, std::size_t half_count) const;

  /// All edges: motion, then neighbours, then loops.
  std::vector<SurveyEdge> Edges() const;

  /// For each drive, the first drive of those that edges join it with.
  std::vector<std::size_t> GroupOfDrives() const;

  /// The nodes that edges lead to from `from` over paths of at most `limit_m`, each with the
  /// shortest such path: what lies between two nodes decides how well one knows where they are to
  /// one another. Loops and fixes count as `costs` say.
  std::vector<std::pair<std::size_t, double>> PathsFrom(std::size_t from, double limit_m,
                                                        const PathCosts& costs) const;

  /// For each drive, whether a fix places it or one that edges join it with.
  std::vector<bool> HasFix() const;

  std::vector<Pose2> T_map_nodes;
  std::vector<SurveyEdge> motions;     ///< by ego-motion, between successive nodes
  std::vector<SurveyEdge> neighbours;  ///< registrations of nodes of a drive a few apart
  std::vector<SurveyEdge> loops;       ///< registrations of all others
  std::vector<NodeFix> fixes;          ///< of drives that are placed by them

 private:
  std::vector<const DriveTrack*> tracks_;
  std::vector<std::size_t> first_node_;  // of each drive, and the end
};

}  // namespace dcloc
