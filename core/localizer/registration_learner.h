#pragma once

#include <chrono>
#include <cstddef>
#include <optional>

#include "core/geometry/pose_estimate.h"
#include "core/localizer/current_pose.h"
#include "core/localizer/workspace.h"
#include "core/odometry/ego_motion.h"
#include "core/registration/map_matcher.h"
#include "core/uncertainty/beta_monitor.h"

namespace dcloc {

/// Learns beta, the errors of odometry, and the noise of both from accepted registrations.
template <int Dim>
class RegistrationLearner {
 public:
  RegistrationLearner(const Rig& rig, const BetaMonitorOptions& options,
                      const UnobservedSigmas& unobserved)
      : unobserved_(unobserved), beta_monitor_(rig, options) {}

  /// `registration` puts a vehicle that was tracking in the local map of `matcher` at `stamp`. It
  /// is of the sub-map in `workspace`, whose scans span `submap_span`. Odometry learns of it as if
  /// it had the covariance `blunt_m2` of (x, y) beside its own.
  void OnAccepted(Stamp stamp, const Registration<Dim>& registration,
                  const EgoVelocity& ego_velocity, std::chrono::nanoseconds submap_span,
                  const Eigen::Matrix2d& blunt_m2, const MapMatcher<Dim>& matcher,
                  EgoMotion& ego_motion, CurrentPose<Dim>& pose, Workspace<Dim>& workspace);

  /// The same of a vehicle whose pose is doubted, and near which `registration` was accepted. It
  /// tells the odometry alone how far the vehicle has turned: at a wrong place along a street, too.
  void OnDoubted(Stamp stamp, const Registration<Dim>& registration,
                 std::chrono::nanoseconds submap_span, const MapMatcher<Dim>& matcher,
                 EgoMotion& ego_motion, const CurrentPose<Dim>& pose);

  /// What is known of the beta of a radar.
  BetaCheck CheckBeta(std::size_t radar_index) const { return beta_monitor_.Check(radar_index); }

 private:
  // Registrations that share scans share their errors.
  bool IsDue(Stamp stamp, std::chrono::nanoseconds submap_span) {
    if (learned_ && stamp - *learned_ <= submap_span) return false;
    learned_ = stamp;
    return true;
  }
  void TellOdometry(const Registration<Dim>& registration, const Eigen::Matrix2d& blunt_m2,
                    const MapMatcher<Dim>& matcher, const CurrentPose<Dim>& pose,
                    EgoMotion& ego_motion) const;

  UnobservedSigmas unobserved_;
  BetaMonitor<Dim> beta_monitor_;
  std::optional<Stamp> learned_;  // when the odometry and the noise were
};

}  // namespace dcloc
