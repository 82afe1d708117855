#include "core/calibration/static_return.h"

#include <algorithm>

namespace dcloc {

Eigen::Matrix<double, 2, kCalibrationParameters> JacobianByParameters(
    const ScanGeometry& scan, const Eigen::Vector2d& position_m, double cos_elevation) {
  const auto turned = [](const Eigen::Vector2d& v) { return Eigen::Vector2d(-v.y(), v.x()); };
  constexpr double kMinRange_m = 1.0;
  const Eigen::Vector2d sight_m = position_m - scan.radar_m;
  const Eigen::Vector2d u = cos_elevation * sight_m.normalized();
  Eigen::Matrix<double, 2, kCalibrationParameters> jacobian;
  const auto column = [&jacobian](CalibrationParameter parameter) {
    return jacobian.col(static_cast<Eigen::Index>(parameter));
  };
  // A static target's range rate is -u . v.
  column(CalibrationParameter::kBeta) = u * u.dot(scan.radar_velocity_mps);
  column(CalibrationParameter::kTimeOffset) =
      scan.vehicle_velocity_mps + scan.yaw_rate_radps * turned(position_m - scan.vehicle_m);
  column(CalibrationParameter::kRangeBias) = -u;
  column(CalibrationParameter::kMountYaw) = turned(sight_m);
  // The slant range over a ground range r is r + h^2 / 2r.
  column(CalibrationParameter::kHeightSquare) =
      scan.planar ? Eigen::Vector2d(-u / (2.0 * std::max(sight_m.norm(), kMinRange_m)))
                  : Eigen::Vector2d::Zero();
  column(CalibrationParameter::kRangeScale) =
      scan.planar ? Eigen::Vector2d(-u * sight_m.norm()) : Eigen::Vector2d::Zero();
  return jacobian;
}

}  // namespace dcloc
