#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/calibration/calibration.h"

namespace dcloc {

/// The poses and velocities at one scan, in the xy plane of the map, relative to a local origin.
struct ScanGeometry {
  Eigen::Vector2d radar_m;
  Eigen::Vector2d radar_velocity_mps;
  Eigen::Vector2d vehicle_m;
  Eigen::Vector2d vehicle_velocity_mps;
  double yaw_rate_radps;
  bool planar;          ///< the radar measures no elevation
  std::uint32_t radar;  ///< index in the rig
  std::uint32_t stand;  ///< scans of one radar and one stand were taken from nearly the same pose
};

/// One static return in the same plane.
struct StaticReturn {
  Eigen::Vector2d position_m;
  Eigen::Matrix2d covariance_m2;
  double range_m;
  double cos_elevation;  ///< of its line of sight
  std::uint32_t scan;
};

/// The static returns of one map frame.
struct FrameReturns {
  std::vector<ScanGeometry> scans;
  std::vector<StaticReturn> returns;
};

/// Jacobian of a return's position by the parameters of its radar, in CalibrationParameter's order,
/// for a return at `position_m` seen from `scan` (METHOD 1).
Eigen::Matrix<double, 2, kCalibrationParameters> JacobianByParameters(
    const ScanGeometry& scan, const Eigen::Vector2d& position_m, double cos_elevation);

}  // namespace dcloc
