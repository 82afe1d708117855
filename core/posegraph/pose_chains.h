#pragma once

#include <optional>

#include "core/posegraph/pose_graph.h"

namespace dcloc {

/// The accepted chain of states and, while its absolute pose factors are rejected as outliers, an
/// alternative chain made of those. A burst of false registrations never lasts; a chain that has
/// gone wrong is contradicted for good. So the alternative replaces the accepted chain when
/// `takeover_support` of its own factors in a row agree and the accepted chain took none of them;
/// fewer are enough where it began near by.
template <int Dim>
class PoseChains {
 public:
  explicit PoseChains(const PoseGraphOptions& options)
      : options_(options), accepted_chain_(options) {}

  /// Forgets every state.
  void Clear();

  /// As in PoseGraph; a reset drops the alternative.
  void Reset(const PoseEstimate<Dim>& prior,
             const TangentMatrix<Dim>& systematic = TangentMatrix<Dim>::Zero());
  void AddState(const PoseEstimate<Dim>& odometry) { AddState(odometry, odometry.covariance); }
  void AddState(const PoseEstimate<Dim>& odometry, const TangentMatrix<Dim>& noise_covariance);
  void ChangeFrame(const Pose<Dim>& T_new_old);
  bool empty() const { return accepted_chain_.empty(); }
  PoseEstimate<Dim> Newest() const { return accepted_chain_.Newest(); }
  TangentMatrix<Dim> NewestNoiseCovariance() const {
    return accepted_chain_.NewestNoiseCovariance();
  }

  /// Gives the newest state an absolute pose factor, tests it, and solves. The test is that of the
  /// chain that was accepted before the call. After a takeover `is_accepted` is true, as the new
  /// chain holds the factor, and `squared_distance` is still to the chain that was replaced: it
  /// exceeds the gate.
  InnovationTest AddAbsolutePose(const AbsolutePoseFactor<Dim>& factor);

  /// The same for a position that is no registration. One that fails the test is left out; it is no
  /// factor of the alternative, which only registrations can speak for.
  InnovationTest AddPosition(const AbsolutePoseFactor<Dim>& factor);

 private:
  void UpdateAlternative(const AbsolutePoseFactor<Dim>& factor, double squared_distance);

  PoseGraphOptions options_;
  PoseGraph<Dim> accepted_chain_;
  std::optional<PoseGraph<Dim>> alternative_;
  int support_ = 0;
  int support_needed_ = 0;
};

}  // namespace dcloc
