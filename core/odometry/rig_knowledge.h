#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"

namespace dcloc {

/// What was learned of one radar beside its description. What is absent has not been learned.
struct RadarKnowledge {
  std::string radar_id;
  /// By how much it looks further to the left than its mount says [rad].
  std::optional<ScalarEstimate> mount_yaw_error;
  /// By how much its stamps are ahead of those of the other radars [s]. Reported only: clocks are
  /// set between sessions, and a session finds it by itself in its first scans.
  std::optional<ScalarEstimate> clock_ahead;
  /// By how much later than `time_offset_s` describes its scans are stamped [s].
  std::optional<ScalarEstimate> stamp_delay;
  /// By how much its ranges are longer than `range_bias_m` describes [m].
  std::optional<ScalarEstimate> range_bias_error;
  /// By how much the described beta is too small [s]. Reported only: a session's scans are
  /// compensated by the beta that its rig describes.
  std::optional<ScalarEstimate> beta_error;

  bool empty() const {
    return !mount_yaw_error && !clock_ahead && !stamp_delay && !range_bias_error && !beta_error;
  }
};

/// What was learned of a vehicle's radars and odometry while it drove. A later session may begin
/// with it.
struct RigKnowledge {
  std::vector<RadarKnowledge> radars;  ///< those of which something was learned
  /// By how much later than its stamp the reported velocity was true [s].
  std::optional<ScalarEstimate> odometry_delay;
  /// What the reported speed is to be multiplied by.
  std::optional<ScalarEstimate> wheel_scale;
  /// What is to be added to the reported yaw rate [rad/s].
  std::optional<ScalarEstimate> yaw_rate_correction;

  bool empty() const {
    return radars.empty() && !odometry_delay && !wheel_scale && !yaw_rate_correction;
  }
  /// Of that radar; it is added where it is not there yet.
  RadarKnowledge& Of(const std::string& radar_id);
  /// Nothing where nothing is known of that radar.
  const RadarKnowledge* Find(const std::string& radar_id) const;
};

/// The bounds of what a session may begin with (dcloc.v1.RigKnowledge states them). No more is
/// learned than these allow.
inline constexpr double kMaxKnownMountYawError_rad = 0.35;
inline constexpr double kMaxKnownDelay_s = 1.0;
inline constexpr double kMaxKnownStampDelay_s = 0.35;
inline constexpr double kMaxKnownRangeBiasError_m = 2.0;
inline constexpr double kMinKnownScale = 0.4, kMaxKnownScale = 1.6;
inline constexpr double kMaxKnownYawRateCorrection_radps = 0.15;

/// OK, or InvalidArgument that names the value and the bound.
absl::Status Validate(const RigKnowledge& knowledge);

/// Whether something is known that was not, or differs by more than its deviation, or is known
/// twice as well.
bool HasChanged(const RigKnowledge& before, const RigKnowledge& now);

}  // namespace dcloc
