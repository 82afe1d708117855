#pragma once

#include <Eigen/Core>

#include "core/geometry/pose.h"
#include "core/radar/ego_velocity.h"

namespace dcloc {

/// d (Exp(xi) p) / d xi at zero.
inline Eigen::Matrix<double, 2, 3> ByPose(const Eigen::Vector2d& p_m) {
  return (Eigen::Matrix<double, 2, 3>() << 1.0, 0.0, -p_m.y(), 0.0, 1.0, p_m.x()).finished();
}
inline Eigen::Matrix<double, 3, 6> ByPose(const Eigen::Vector3d& p_m) {
  return (Eigen::Matrix<double, 3, 6>() << Eigen::Matrix3d::Identity(), -Skew(p_m)).finished();
}

/// Errors of a radar's description, in this order.
enum RadarError { kBetaError, kRangeBiasError, kTimeOffsetError, kMountYawError, kRadarErrors };

/// How a static point at `p_m`, seen by a radar at `origin_m` (both in the vehicle frame), moves in
/// that frame by a unit of each error: [m/s, 1, m/s, m].
template <int Dim>
Eigen::Matrix<double, Dim, kRadarErrors> ByRadarErrors(const Eigen::Matrix<double, Dim, 1>& p_m,
                                                       const Eigen::Vector3d& origin_m,
                                                       const EgoVelocity& ego_velocity) {
  Eigen::Vector3d point_m = origin_m;
  point_m.head<Dim>() = p_m;
  const Eigen::Vector3d ray_m = point_m - origin_m;
  const Eigen::Vector3d along = ray_m.normalized();
  const Eigen::Vector3d radar_mps =
      ego_velocity.linear_mps + ego_velocity.angular_radps.cross(origin_m);
  Eigen::Matrix<double, 3, kRadarErrors> shifts;
  shifts << along.dot(radar_mps) * along, -along,
      ego_velocity.linear_mps + ego_velocity.angular_radps.cross(point_m),
      Eigen::Vector3d::UnitZ().cross(ray_m);
  return shifts.topRows<Dim>();
}

}  // namespace dcloc
