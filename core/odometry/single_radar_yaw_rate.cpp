#include "core/odometry/single_radar_yaw_rate.h"

#include <algorithm>
#include <cmath>

#include "core/radar/radar_model.h"

namespace dcloc {
namespace {

// Where a radar sits closer to the origin, it hardly sees the vehicle turn.
constexpr double kMinAhead_m = 0.5;
// The angle is learned from this speed on, by so many readings, and forgotten after some fifty.
constexpr double kMinSpeed_mps = 3.0;
constexpr int kMinCount = 20;
constexpr double kForgettingFactor = 0.98;
// A mount that was learned differs by no more than this.
constexpr double kMaxAngle_rad = 1.5 * kRadPerDeg;
// The vehicle turns about a point no further than this from its frame's origin.
constexpr double kMaxOffset_m = 1.5;

}  // namespace

std::optional<SingleRadarReading> SingleRadarYawRate::OnYawRates(double speed_mps, double ahead_m,
                                                                 const ScalarEstimate& doppler,
                                                                 const Gyroscope& gyroscope) {
  const double gyroscope_radps = gyroscope.yaw_rate_radps;
  if (std::abs(ahead_m) < kMinAhead_m) return std::nullopt;
  const double yaw_rate_radps = doppler.value - angle_rad_.mean * speed_mps / ahead_m;
  const double turn_radps = std::sqrt(std::abs(doppler.value * gyroscope_radps));
  const double most_mps = kMaxAngle_rad * std::abs(speed_mps) + kMaxOffset_m * turn_radps;
  const double beyond_radps =
      std::max(0.0, std::abs(yaw_rate_radps - gyroscope_radps) - most_mps / std::abs(ahead_m));
  const bool is_known = angle_rad_.count >= kMinCount;
  if (gyroscope.is_sound && speed_mps >= kMinSpeed_mps && (beyond_radps == 0.0 || !is_known)) {
    angle_rad_.Add((doppler.value - gyroscope_radps) * ahead_m / speed_mps, kForgettingFactor);
  }
  if (!is_known) return std::nullopt;
  return SingleRadarReading{.yaw_rate = {yaw_rate_radps, doppler.variance},
                            .beyond_gyroscope_radps = beyond_radps};
}

}  // namespace dcloc
