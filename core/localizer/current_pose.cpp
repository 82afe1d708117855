#include "core/localizer/current_pose.h"

#include "core/geometry/covariance.h"

namespace dcloc {

template <int Dim>
void CurrentPose<Dim>::OnMotion(const Motion& motion) {
  noise_scales_.OnMotion(ToEstimate<Dim>(motion));
  since_state_ = Compose(since_state_, motion);
}

template <int Dim>
void CurrentPose<Dim>::OnGap() {
  noise_scales_.OnDiscontinuity();
  gap_since_state_ = true;
}

template <int Dim>
void CurrentPose<Dim>::Reset(const PoseEstimate<Dim>& now, const TangentMatrix<Dim>& systematic) {
  chains_.Reset(now, systematic);
  since_state_ = {};
}

template <int Dim>
void CurrentPose<Dim>::AddState() {
  chains_.AddState(OdometryEdge(), OdometryNoise());
  since_state_ = {};
  gap_since_state_ = false;
}

template <int Dim>
PoseEstimate<Dim> CurrentPose<Dim>::Now() const {
  const PoseEstimate<Dim> newest = chains_.Newest();
  const PoseEstimate<Dim> motion = ToEstimate<Dim>(since_state_);
  return {.pose = newest.pose * motion.pose,
          .covariance = ComposeCovariance<Dim>(newest.covariance, motion.pose, motion.covariance)};
}

template <int Dim>
TangentMatrix<Dim> CurrentPose<Dim>::NoiseCovarianceNow() const {
  return ComposeCovariance<Dim>(chains_.NewestNoiseCovariance(), ToEstimate<Dim>(since_state_).pose,
                                OdometryNoise());
}

// What is learned of odometry says nothing of what happened in a gap.
template <int Dim>
PoseEstimate<Dim> CurrentPose<Dim>::OdometryEdge() const {
  PoseEstimate<Dim> edge = ToEstimate<Dim>(since_state_);
  if (!gap_since_state_) edge.covariance = noise_scales_.OdometryWeightCovariance(edge.covariance);
  return edge;
}

template <int Dim>
TangentMatrix<Dim> CurrentPose<Dim>::OdometryNoise() const {
  const TangentMatrix<Dim> covariance = ToEstimate<Dim>(since_state_).covariance;
  return gap_since_state_ ? covariance : noise_scales_.OdometryCovariance(covariance);
}

template class CurrentPose<2>;
template class CurrentPose<3>;

}  // namespace dcloc
