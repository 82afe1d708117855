#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/sdk/pose/pose_estimate.h"
#include "client/sdk/pose/rigid_pose.h"

namespace dcloc::client {

/// An answer with a pose.
struct Anchor {
  std::int64_t stamp_ns = 0;
  RigidPose T_map_vehicle;
  Matrix6 covariance{};
  v1::LocalizationState state = v1::LOCALIZATION_STATE_UNSPECIFIED;
  bool jumped = false;  ///< it does not follow the one before it
};

/// The vehicle's velocity as it gave it.
struct GivenVelocity {
  std::int64_t stamp_ns = 0;
  Vector6 velocity{};                ///< in the vehicle frame
  Vector6 variances{};               ///< of what is constantly wrong with it
  Vector6 noise{};                   ///< variance times seconds of what averages out over readings
  bool has_usual_variances = false;  ///< it came without a covariance
};

/// The time from `begin_ns` to the next segment, in which the velocity changes evenly.
struct Segment {
  std::int64_t begin_ns = 0;
  std::int64_t answer_ns = 0;  ///< of the answer before it
  std::int64_t known_ns = 0;   ///< the newest velocity or answer; what comes later is extrapolated
  std::int64_t state = 0;      ///< of that answer, a v1::LocalizationState
  RigidPose begin;             ///< from the answer by the vehicle's motion
  Vector6 velocity{};          ///< at the begin
  Vector6 acceleration{};      ///< its change per second
  Vector6 correction{};        ///< per second since the answer, so that the next answer is met
  std::int64_t origin_ns = 0;  ///< since when what is not known of the motion adds up
  Vector3 origin_m{};          ///< where it began
  Matrix6 covariance{};        ///< there
  Vector6 variances{};         ///< of the velocity; 0 where the next answer is known
  Vector6 noise{};             ///< of it, too, as of GivenVelocity
};

/// Poses from the first segment on, with no gap. `anchors` and `given` are by ascending stamp.
std::vector<Segment> MakeTimeline(const std::vector<Anchor>& anchors,
                                  const std::vector<GivenVelocity>& given,
                                  const PoseOptions& options);

/// The pose at a stamp that is not before the segment's begin.
PoseEstimate Evaluate(const Segment& segment, std::int64_t stamp_ns, const PoseOptions& options);

}  // namespace dcloc::client
