#pragma once

#include <chrono>
#include <cstdint>

#include "absl/status/status.h"
#include "client/sdk/pose/rigid_pose.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// Where the vehicle was, or is, at one moment. Plain numbers, so that nothing is allocated.
struct PoseEstimate {
  std::int64_t stamp_ns = 0;
  RigidPose T_map_vehicle;
  /// Of (x, y, z, rotation about x, y, z) along and about the map's axes, as on the wire.
  Matrix6 covariance{};
  /// Linear [m/s] and turn rate [rad/s], in the vehicle frame.
  Vector6 velocity{};
  std::int64_t answer_stamp_ns = 0;  ///< of the answer that it goes out from
  v1::LocalizationState state = v1::LOCALIZATION_STATE_UNSPECIFIED;  ///< of that answer
};

/// How poses are told between answers and after them.
struct PoseOptions {
  /// So long after the newest answer poses are told; later stamps are refused.
  std::chrono::milliseconds max_ahead{500};
  /// So long back they are told, or as long as the last 64 answers reach.
  std::chrono::milliseconds kept{500};
  /// A vehicle whose own velocity is older than this is taken to move as the answers say.
  std::chrono::milliseconds max_velocity_age{300};
  /// Deviation of a velocity that the vehicle gave without a covariance: a constant, and a share of
  /// the speed, which is the learned scale's deviation once the server has learned one.
  double velocity_sigma_mps = 0.03;
  double velocity_scale_sigma = 0.005;
  double turn_rate_sigma_radps = 0.002;
  /// By how much the velocity may change once nothing newer is known.
  double acceleration_sigma_mps2 = 1.5;
  double turn_acceleration_sigma_radps2 = 0.15;
  /// How fast `SmoothPoseAt` follows a jump of the answers. Larger ones are followed at once.
  double bleed_mps = 0.5;
  double bleed_radps = 0.05;
  double max_smoothed_m = 5.0;
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const PoseOptions& options);

}  // namespace dcloc::client
