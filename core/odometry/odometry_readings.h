#pragma once

#include <cstddef>
#include <optional>

#include "core/odometry/doppler_ego_velocity.h"
#include "core/odometry/source_monitor.h"
#include "core/radar/scan.h"

namespace dcloc {

/// What the vehicle says, corrected, and what Doppler says, for the comparison of sources. The yaw
/// rate of a single radar is that of a vehicle without side slip at its frame's origin; it may be
/// used, but is no evidence against a gyroscope.
inline OdometryReadings ReadingsOf(const std::optional<EgoVelocity>& reported,
                                   const std::optional<DopplerEgoVelocity>& doppler,
                                   const std::optional<DopplerEgoVelocity>& alternative,
                                   std::size_t radar_count) {
  const auto speed_of = [](const EgoVelocity& velocity) {
    return ScalarEstimate{velocity.linear_mps.x(), (*velocity.covariance)(0, 0)};
  };
  const auto yaw_rate_of = [](const EgoVelocity& velocity) {
    return ScalarEstimate{velocity.angular_radps.z(), (*velocity.covariance)(5, 5)};
  };
  OdometryReadings readings;
  if (reported) {
    readings.wheel_speed = speed_of(*reported);
    readings.yaw_rate = yaw_rate_of(*reported);
  }
  if (doppler) {
    readings.doppler_speed = speed_of(doppler->ego_velocity);
    if (radar_count > 1) readings.doppler_yaw_rate = yaw_rate_of(doppler->ego_velocity);
    readings.doppler_direction_count = doppler->direction_count;
    readings.doppler_radar_count = radar_count;
  }
  if (alternative) {
    readings.alternative_speed = speed_of(alternative->ego_velocity);
    if (radar_count > 1) readings.alternative_yaw_rate = yaw_rate_of(alternative->ego_velocity);
  }
  return readings;
}

}  // namespace dcloc
