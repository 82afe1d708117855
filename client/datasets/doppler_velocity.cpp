#include "client/datasets/doppler_velocity.h"

#include <array>
#include <cmath>

#include "core/odometry/doppler_ego_velocity.h"

namespace dcloc {
namespace {

constexpr double kTurnRateSigma_radps = 0.005;  // of a gyroscope of MEMS, with its bias
constexpr double kVerticalSigma_mps = 0.1;      // of what range rates in the plane do not tell
constexpr double kTiltRateSigma_radps = 0.05;

}  // namespace

std::optional<EgoVelocity> VelocityByDoppler(const Scan& scan, const RadarModel& radar,
                                             const Eigen::Vector3d& turn_rate_radps) {
  // A metre before an axle that does not slip the radar's velocity across is the yaw rate there:
  // so the estimate for one radar is both components of its velocity, whatever turns the vehicle.
  RadarModel ahead = radar;
  ahead.T_vehicle_radar.translation_m = Eigen::Vector3d::UnitX();
  const std::array<RadarScan, 1> scans = {{{&scan, &ahead}}};
  const auto estimate = EstimateEgoVelocity(scans, /*seed=*/0);
  if (!estimate) return std::nullopt;
  const EgoVelocity& axle = estimate->ego_velocity;
  const Matrix6d& axle_covariance = *axle.covariance;
  const Eigen::Vector3d v_radar(axle.linear_mps.x(), axle.linear_mps.y() + axle.angular_radps.z(),
                                0.0);
  const Eigen::Vector3d& lever_m = radar.T_vehicle_radar.translation_m;
  EgoVelocity velocity;
  velocity.angular_radps = turn_rate_radps;
  velocity.linear_mps = v_radar - Eigen::Vector3d(turn_rate_radps.cross(lever_m));
  velocity.linear_mps.z() = 0.0;
  const double turn_variance = std::pow(kTurnRateSigma_radps, 2);
  Vector6d variances;
  variances << axle_covariance(0, 0) + std::pow(lever_m.y(), 2) * turn_variance,
      axle_covariance(1, 1) + 2.0 * axle_covariance(1, 5) + axle_covariance(5, 5) +
          std::pow(lever_m.x(), 2) * turn_variance,
      std::pow(kVerticalSigma_mps, 2), std::pow(kTiltRateSigma_radps, 2),
      std::pow(kTiltRateSigma_radps, 2), turn_variance;
  velocity.covariance = variances.asDiagonal();
  return velocity;
}

}  // namespace dcloc
