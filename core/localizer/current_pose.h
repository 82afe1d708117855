#pragma once

#include "core/geometry/pose_estimate.h"
#include "core/odometry/motion.h"
#include "core/posegraph/pose_chains.h"
#include "core/uncertainty/noise_scale_estimator.h"

namespace dcloc {

/// The pose graph's newest state, carried to the newest scan by odometry: with what it weighs, and
/// with what it varies by (METHOD section 9). Frames are those of the local map.
template <int Dim>
class CurrentPose {
 public:
  CurrentPose(const PoseGraphOptions& graph_options, const NoiseScaleOptions& noise_options)
      : noise_options_(noise_options), chains_(graph_options), noise_scales_(noise_options) {}

  /// The vehicle moved so since the last call.
  void OnMotion(const Motion& motion);

  /// Odometry was interrupted: what was learned of its noise says nothing of this motion.
  void OnGap();

  /// What follows is not compared with what was before.
  void OnDiscontinuity() { noise_scales_.OnDiscontinuity(); }

  /// What was learned of the noise was learned of something else.
  void ResetNoise() { noise_scales_ = NoiseScaleEstimator<Dim>(noise_options_); }

  /// Starts anew at the newest scan; `systematic` as of PoseGraph::Reset.
  void Reset(const PoseEstimate<Dim>& now,
             const TangentMatrix<Dim>& systematic = TangentMatrix<Dim>::Zero());
  /// Starts anew at the newest scan with a pose, and with what it varies by beside what it weighs.
  void Restore(const PoseEstimate<Dim>& now, const NoiseKnowledge& noise) {
    Reset(now);
    noise_scales_.Restore(noise);
  }
  /// There is no pose any more.
  void Clear() { chains_.Clear(); }

  /// The pose graph gets a state at the newest scan. Needs a pose, as all that follows.
  void AddState();
  InnovationTest AddAbsolutePose(const AbsolutePoseFactor<Dim>& factor) {
    return chains_.AddAbsolutePose(factor);
  }
  /// The newest state is here, by a position fix. One that is an outlier is left out.
  InnovationTest AddPosition(const PoseEstimate<Dim>& position) {
    return chains_.AddPosition({.pose = position.pose,
                                .covariance = position.covariance,
                                .weight_covariance = position.covariance,
                                .noise_covariance = {}});
  }
  void ChangeFrame(const Pose<Dim>& T_new_old) { chains_.ChangeFrame(T_new_old); }

  /// The newest state.
  PoseEstimate<Dim> Newest() const { return chains_.Newest(); }
  /// At the newest scan.
  PoseEstimate<Dim> Now() const;
  /// By what that varies.
  TangentMatrix<Dim> NoiseCovarianceNow() const;

  /// Learns from registrations; see NoiseScaleEstimator.
  NoiseScaleEstimator<Dim>& noise_scales() { return noise_scales_; }
  const NoiseScaleEstimator<Dim>& noise_scales() const { return noise_scales_; }

 private:
  PoseEstimate<Dim> OdometryEdge() const;
  TangentMatrix<Dim> OdometryNoise() const;

  NoiseScaleOptions noise_options_;
  PoseChains<Dim> chains_;
  NoiseScaleEstimator<Dim> noise_scales_;
  Motion since_state_;            // from the newest state to the newest scan
  bool gap_since_state_ = false;  // odometry was interrupted meanwhile
};

}  // namespace dcloc
