#pragma once

#include <chrono>
#include <span>
#include <utility>

#include "absl/status/status.h"
#include "core/geometry/pose_estimate.h"
#include "core/options/option_fields.h"
#include "core/radar/scan.h"

namespace dcloc {

/// The vehicle's motion between two moments.
struct Motion {
  Pose3 T_from_to;
  Matrix6d covariance = Matrix6d::Zero();  ///< in the tangent space on the right
};

/// The deviation of a speed of which nothing is known: most road vehicles drive below twice this.
inline constexpr double kUnknownSpeedSigma_mps = 15.0;

/// How the error of an integrated ego-velocity grows.
struct MotionOptions {
  /// How long the error of an ego-velocity keeps its value. A scale factor stays for minutes, noise
  /// for one sample; the spread of the integrated pose grows as if by steps of this length.
  std::chrono::nanoseconds correlation_time = std::chrono::seconds(2);
  /// Deviations of an ego-velocity that comes without a covariance.
  double linear_sigma_mps = 0.1;
  double vertical_sigma_mps = 0.05;
  double yaw_rate_sigma_radps = 0.005;
  double tilt_rate_sigma_radps = 0.01;
  /// A car changes its speed by up to some metres per second in a second, its yaw rate by less than
  /// one radian per second: what may have happened between two velocities that lie apart in time.
  double acceleration_sigma_mps2 = 3.0;
  double yaw_acceleration_sigma_radps2 = 0.5;
};
std::span<const OptionField<MotionOptions>> FieldsOf(const MotionOptions& options);
absl::Status Validate(const MotionOptions& options);

/// `ego_velocity` with a covariance: its own or, where it has none, the options' and on top a
/// fraction `scale_sigma` of the speed.
EgoVelocity WithCovariance(const EgoVelocity& ego_velocity, double scale_sigma,
                           const MotionOptions& options);

/// Motion over `duration` from the velocities at its two ends: Exp of their mean, which is second
/// order where the printed Exp(omega_i dt) of METHOD eq 8 is first. Both have a covariance. Its own
/// spread holds what the velocity may have done between the two, which grows as `duration`^2.
Motion Integrate(const EgoVelocity& begin, const EgoVelocity& end,
                 std::chrono::nanoseconds duration, const MotionOptions& options);

/// The motion `first`, then `second`, whose errors are independent.
Motion Compose(const Motion& first, const Motion& second);

/// The motion back.
Motion Inverse(const Motion& motion);

/// The two parts of a steady motion, of which the first takes `fraction` of its time, [0, 1].
std::pair<Motion, Motion> Split(const Motion& motion, double fraction);

/// A motion in the dimension of a pipeline.
template <int Dim>
PoseEstimate<Dim> ToEstimate(const Motion& motion) {
  return FromSpace<Dim>(motion.T_from_to, motion.covariance);
}

}  // namespace dcloc
