#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/pose_estimate.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// A measured relative pose of two nodes.
struct SurveyEdge {
  std::size_t from = 0;
  std::size_t to = 0;
  PoseEstimate<2> T_from_to;
  /// False where it may be wrong altogether: then it counts only as far as it agrees with the
  /// others.
  bool is_certain = false;
};

/// A measured position of the vehicle near a node; it may be wrong altogether.
struct NodeFix {
  std::size_t node = 0;
  Eigen::Vector2d p_node = Eigen::Vector2d::Zero();  ///< of the vehicle then, in the node's frame
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();
  double sigma_m = 1.0;
};

struct SurveyGraphSolverOptions {
  /// An uncertain edge with a squared Mahalanobis distance beyond this is left out: with three
  /// degrees of freedom, and two of a fix.
  double max_squared_edge_distance = kChiSquare999With3Dof;
  double max_squared_fix_distance = kChiSquare999With2Dof;
  /// In each round of graduated non-convexity the surrogate cost's control parameter grows by this.
  double growth = 2.0;
  int max_round_count = 40;
  int max_iterations = 20;  ///< of the solver, in each round
};
std::span<const OptionField<SurveyGraphSolverOptions>> FieldsOf(
    const SurveyGraphSolverOptions& options);
absl::Status Validate(const SurveyGraphSolverOptions& options);

/// What the nodes' poses are, and what was kept.
struct SurveyGraphSolution {
  std::vector<Pose2> T_map_nodes;
  std::vector<double> edge_weights;  ///< [0, 1]; 1 of certain edges, near 0 of what was left out
  std::vector<double> fix_weights;
};

/// Places nodes so that measured relative poses and positions fit best. Edges and fixes that
/// contradict the others are left out: truncated least squares by graduated non-convexity (Yang et
/// al., "Graduated Non-Convexity for Robust Spatial Perception", RA-L 2020). `T_map_nodes` is the
/// initial guess. In each part of the graph that has no fix the first node stays where it is.
/// FailedPrecondition when the solver finds nothing.
absl::StatusOr<SurveyGraphSolution> SolveSurveyGraph(std::span<const Pose2> T_map_nodes,
                                                     std::span<const SurveyEdge> edges,
                                                     std::span<const NodeFix> fixes,
                                                     const SurveyGraphSolverOptions& options);

/// For each node the first node of the part of the graph that it belongs to: what edges join.
std::vector<std::size_t> PartsOf(std::size_t node_count, std::span<const SurveyEdge> edges);

/// Squared Mahalanobis distance of an edge's measurement from where the nodes lie.
double SquaredDistance(const SurveyEdge& edge, std::span<const Pose2> T_map_nodes);

}  // namespace dcloc
