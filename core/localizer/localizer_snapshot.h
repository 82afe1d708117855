#pragma once

#include <chrono>
#include <vector>

#include "absl/status/status.h"
#include "core/localizer/health.h"
#include "core/localizer/pose_resets.h"
#include "core/localizer/tracking_state_machine.h"
#include "core/odometry/rig_knowledge.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/stamp.h"
#include "core/relocalization/initial_pose.h"
#include "core/uncertainty/noise_knowledge.h"

namespace dcloc {

/// What another localizer of the same vehicle, rig and map goes on from: where the vehicle was at
/// one scan, how it moved, what was learned, and how far the pose was confirmed. The sub-map and
/// the window of past poses are no part of it. The scans of the second that follows fill them
/// again, and three registrations confirm the pose.
struct LocalizerSnapshot {
  Stamp stamp{};  ///< of the newest scan, on the vehicle's clock; so are all stamps here
  InitialPose pose{.T_map_vehicle = {}, .covariance = Matrix6d::Zero()};
  EgoVelocity velocity;  ///< with its covariance
  TrackingSnapshot tracking;
  RigKnowledge known;
  NoiseKnowledge noise;
  PoseResets resets;
  double mean_nis = 1.0;         ///< of ProtectionLevel
  double contradiction_m = 0.0;  ///< of ProtectionLevel
  int registration_count = 1;    ///< registrations since the pose was found, outliers too
  /// By how much each radar's clock is ahead, in the rig's order; empty: all are one.
  std::vector<std::chrono::nanoseconds> clocks_ahead;
};

/// OK, or InvalidArgument that names the field, the value and the bound. A valid snapshot may be
/// wrong, as a prior may; it breaks nothing.
absl::Status Validate(const LocalizerSnapshot& snapshot);

}  // namespace dcloc
