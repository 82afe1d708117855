#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/odometry/doppler_ego_velocity.h"
#include "core/odometry/odometry_sources.h"
#include "core/radar/scan.h"

namespace dcloc {

/// What the vehicle says, corrected, and what Doppler says, for the comparison of sources. The yaw
/// rate of a single radar is that of a vehicle without side slip at its frame's origin: evidence
/// against a gyroscope is what SingleRadarYawRate makes of it, `single_radar`.
inline OdometryReadings ReadingsOf(const std::optional<EgoVelocity>& reported,
                                   const std::optional<DopplerEgoVelocity>& doppler,
                                   const std::optional<DopplerEgoVelocity>& alternative,
                                   const std::optional<SingleRadarReading>& single_radar,
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
    readings.single_radar = single_radar;
    readings.doppler_direction_count = doppler->direction_count;
    readings.moving_direction_count = doppler->moving_direction_count;
    readings.standing_direction_count = doppler->standing_direction_count;
    readings.doppler_radar_count = radar_count;
  }
  if (alternative) {
    readings.alternative_speed = speed_of(alternative->ego_velocity);
    if (radar_count > 1) readings.alternative_yaw_rate = yaw_rate_of(alternative->ego_velocity);
  }
  return readings;
}

/// Squared Mahalanobis distance of two independent estimates, over v_x and yaw rate: the components
/// that both really measure.
inline double SquaredDistance(const EgoVelocity& a, const EgoVelocity& b) {
  const Matrix6d sum = *a.covariance + *b.covariance;
  const Eigen::Vector2d apart(a.linear_mps.x() - b.linear_mps.x(),
                              a.angular_radps.z() - b.angular_radps.z());
  Eigen::Matrix2d spread;
  spread << sum(0, 0), sum(0, 5), sum(5, 0), sum(5, 5);
  return apart.dot(spread.ldlt().solve(apart));
}

/// Whether the vehicle's `speed` speaks for the motion `a` rather than for `b`.
inline bool IsNearer(const DopplerEgoVelocity& a, const DopplerEgoVelocity& b,
                     const ScalarEstimate& speed) {
  const auto apart = [&](const DopplerEgoVelocity& doppler) {
    return std::abs(doppler.ego_velocity.linear_mps.x() - speed.value);
  };
  return apart(a) < apart(b);
}

}  // namespace dcloc
