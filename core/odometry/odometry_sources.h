#pragma once

#include <bitset>
#include <cstddef>
#include <optional>

#include "core/odometry/scalar_estimate.h"
#include "core/odometry/single_radar_yaw_rate.h"

namespace dcloc {

/// What says how the vehicle moves.
enum class OdometrySource : std::size_t { kWheelSpeed, kYawRate, kDoppler };
inline constexpr std::size_t kOdometrySourceCount = 3;

/// A set of sources, by their number.
using OdometrySources = std::bitset<kOdometrySourceCount>;
inline bool Contains(const OdometrySources& sources, OdometrySource source) {
  return sources[static_cast<std::size_t>(source)];
}

/// What the sources say at one moment; those that are silent are absent. Speeds are forward, of the
/// vehicle frame's origin [m/s]; yaw rates counter-clockwise [rad/s].
struct OdometryReadings {
  std::optional<ScalarEstimate> wheel_speed;
  std::optional<ScalarEstimate> yaw_rate;
  bool yaw_rate_is_repeated = false;  ///< see RepeatedYawRate
  std::optional<ScalarEstimate> doppler_speed;
  std::optional<ScalarEstimate> doppler_yaw_rate;  ///< there only when doppler_speed is
  /// There only when doppler_speed and yaw_rate are, and doppler_yaw_rate is not.
  std::optional<SingleRadarReading> single_radar;
  /// What the targets say that contradict those of `doppler_speed`, where they agree among
  /// themselves: of the two, one is a convoy's, and the hypotheses choose.
  std::optional<ScalarEstimate> alternative_speed;
  std::optional<ScalarEstimate> alternative_yaw_rate;  ///< there only when alternative_speed is
  /// How many directions, ten degrees wide, the Doppler's inliers lie in: one mover that fills the
  /// view is seen in few.
  int doppler_direction_count = 0;
  /// Of these, those with targets that move for a standing vehicle; and directions with targets
  /// that stand still for it, and do not for the Doppler.
  int moving_direction_count = 0;
  int standing_direction_count = 0;
  std::size_t doppler_radar_count = 0;  ///< radars whose scans the Doppler is of
  /// Doppler has told the wheels' scale. If it errs, it says this multiple of the speed, and so do
  /// the wheels by that scale.
  double doppler_multiple = 1.0;
};

/// A motion in the plane, along an arc.
struct ArcMotion {
  double forward_m = 0.0;
  double turn_rad = 0.0;  ///< counter-clockwise

  ArcMotion& operator+=(const ArcMotion& other) {
    forward_m += other.forward_m;
    turn_rad += other.turn_rad;
    return *this;
  }
  ArcMotion& operator-=(const ArcMotion& other) {
    return *this += {-other.forward_m, -other.turn_rad};
  }
};

}  // namespace dcloc
