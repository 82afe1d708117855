#include "core/localizer/registration_learner.h"

#include "core/uncertainty/registration_factor.h"

namespace dcloc {

template <int Dim>
void RegistrationLearner<Dim>::OnAccepted(Stamp stamp, const Registration<Dim>& registration,
                                          const EgoVelocity& ego_velocity,
                                          std::chrono::nanoseconds submap_span,
                                          const Eigen::Matrix2d& blunt_m2,
                                          const MapMatcher<Dim>& matcher, EgoMotion& ego_motion,
                                          CurrentPose<Dim>& pose, Workspace<Dim>& workspace) {
  if (beta_monitor_.IsDue(stamp, submap_span)) {
    beta_monitor_.OnRegistration(
        stamp, workspace.submap,
        matcher.Correspondences(workspace.submap.points, registration.T_local_vehicle,
                                workspace.registration),
        registration.T_local_vehicle, ego_velocity);
  }
  if (!IsDue(stamp, submap_span)) return;
  TellOdometry(registration, blunt_m2, matcher, pose, ego_motion);
  const Pose<Dim> T_map_vehicle =
      FromSpace<Dim>(matcher.T_map_local(), Matrix6d::Zero()).pose * registration.T_local_vehicle;
  pose.noise_scales().OnRegistration(
      {.pose = T_map_vehicle, .covariance = ResidualScaledCovariance<Dim>(registration)});
}

template <int Dim>
void RegistrationLearner<Dim>::OnDoubted(Stamp stamp, const Registration<Dim>& registration,
                                         std::chrono::nanoseconds submap_span,
                                         const MapMatcher<Dim>& matcher, EgoMotion& ego_motion,
                                         const CurrentPose<Dim>& pose) {
  if (!IsDue(stamp, submap_span)) return;
  TellOdometry(registration, Eigen::Matrix2d::Zero(), matcher, pose, ego_motion);
  ego_motion.OnPoseDoubted(/*was_confirmed=*/false);  // where the vehicle is teaches nothing
}

template <int Dim>
void RegistrationLearner<Dim>::TellOdometry(const Registration<Dim>& registration,
                                            const Eigen::Matrix2d& blunt_m2,
                                            const MapMatcher<Dim>& matcher,
                                            const CurrentPose<Dim>& pose,
                                            EgoMotion& ego_motion) const {
  const TangentMatrix<Dim> own = ResidualScaledCovariance<Dim>(registration);
  const PoseEstimate<3> in_space =
      ToSpace<Dim>({.pose = registration.T_local_vehicle,
                    .covariance = pose.noise_scales().RegistrationCovariance(own)},
                   unobserved_);
  Eigen::Matrix3d covariance = FlattenCovariance(in_space.covariance);
  covariance.topLeftCorner<2, 2>() += blunt_m2;
  ego_motion.OnPose(matcher.T_map_local() * in_space.pose, covariance);
}

template class RegistrationLearner<2>;
template class RegistrationLearner<3>;

}  // namespace dcloc
