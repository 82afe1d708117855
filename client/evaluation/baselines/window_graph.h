#pragma once

#include <deque>
#include <optional>

#include "core/posegraph/pose_graph.h"

namespace dcloc {

/// The paper's pose graph (eq 15-17) in the plane: the last n states, odometry edges between
/// neighbours, loop edges to the map. Unlike core's, states that leave the window are dropped
/// without marginalization, and the caller tests the edges.
class WindowGraph {
 public:
  explicit WindowGraph(int window) : window_(window) {}

  /// Starts with one state and its prior.
  void Reset(const PoseEstimate<2>& first);

  /// Adds a state that the edge T_newest_new leads to.
  void AddState(const PoseEstimate<2>& odometry);

  /// Gives the newest state a loop edge.
  void AddAbsolutePose(const PoseEstimate<2>& loop);

  /// Solves for all states by Gauss-Newton.
  void Solve();

  /// The newest state, its covariance as of the last `Solve`.
  const PoseEstimate<2>& Newest() const { return newest_; }

  /// Expresses everything in another map frame.
  void ChangeFrame(const Pose2& T_new_old);

 private:
  struct State {
    Pose2 pose;
    PoseEstimate<2> odometry;             // from the state before
    std::optional<PoseEstimate<2>> loop;  // absent, or cut
  };

  int window_;
  std::deque<State> states_;
  PoseEstimate<2> newest_;
};

}  // namespace dcloc
