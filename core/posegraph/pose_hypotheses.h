#pragma once

#include <optional>

#include "core/posegraph/pose_graph.h"

namespace dcloc {

/// The chain of states that is believed and, while its loop edges are cut, a contender made of
/// those cut edges. A burst of false registrations never lasts; a chain that has gone wrong is
/// contradicted for good. So the contender takes over when `takeover_support` of its own edges in a
/// row agree and the believed chain has accepted none of them.
template <int Dim>
class PoseHypotheses {
 public:
  explicit PoseHypotheses(const PoseGraphOptions& options)
      : options_(options), believed_(options) {}

  /// Forgets every state.
  void Clear();

  /// As in PoseGraph; a reset drops the contender.
  void Reset(const PoseEstimate<Dim>& prior,
             const TangentMatrix<Dim>& lasting = TangentMatrix<Dim>::Zero());
  void AddState(const PoseEstimate<Dim>& odometry) { AddState(odometry, odometry.covariance); }
  void AddState(const PoseEstimate<Dim>& odometry, const TangentMatrix<Dim>& noise);
  void ChangeFrame(const Pose<Dim>& T_new_old);
  bool empty() const { return believed_.empty(); }
  PoseEstimate<Dim> Newest() const { return believed_.Newest(); }
  TangentMatrix<Dim> NewestNoise() const { return believed_.NewestNoise(); }

  /// Gives the newest state a loop edge, tests it (the test is the believed chain's after a
  /// takeover, if there was one), and solves.
  EdgeTest AddLoop(const LoopEdge<Dim>& loop);

 private:
  void Contend(const LoopEdge<Dim>& loop);

  PoseGraphOptions options_;
  PoseGraph<Dim> believed_;
  std::optional<PoseGraph<Dim>> contender_;
  int support_ = 0;
};

}  // namespace dcloc
