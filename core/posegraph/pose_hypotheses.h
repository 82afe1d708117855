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
      : options_(options), accepted_chain_(options) {}

  /// Forgets every state.
  void Clear();

  /// As in PoseGraph; a reset drops the contender.
  void Reset(const PoseEstimate<Dim>& prior,
             const TangentMatrix<Dim>& systematic = TangentMatrix<Dim>::Zero());
  void AddState(const PoseEstimate<Dim>& odometry) { AddState(odometry, odometry.covariance); }
  void AddState(const PoseEstimate<Dim>& odometry, const TangentMatrix<Dim>& noise);
  void ChangeFrame(const Pose<Dim>& T_new_old);
  bool empty() const { return accepted_chain_.empty(); }
  PoseEstimate<Dim> Newest() const { return accepted_chain_.Newest(); }
  TangentMatrix<Dim> NewestNoise() const { return accepted_chain_.NewestNoise(); }

  /// Gives the newest state a loop edge, tests it (the test is the believed chain's after a
  /// takeover, if there was one), and solves.
  EdgeTest AddAbsolutePose(const AbsolutePoseFactor<Dim>& loop);

 private:
  void UpdateAlternative(const AbsolutePoseFactor<Dim>& loop);

  PoseGraphOptions options_;
  PoseGraph<Dim> accepted_chain_;
  std::optional<PoseGraph<Dim>> alternative_;
  int support_ = 0;
};

}  // namespace dcloc
