#include "core/radar/measurement.h"

#include <cmath>

namespace dcloc {
namespace {

double ValueOr(const std::vector<float>& column, std::size_t index, double fallback) {
  return column.empty() ? fallback : static_cast<double>(column[index]);
}

}  // namespace

Measurement MeasurementAt(const Scan& scan, std::size_t index, const RadarModel& radar) {
  return {
      .range_m = scan.range_m[index] - radar.range_bias_m,
      .range_rate_mps = scan.range_rate_mps[index],
      .elevation_rad = radar.has_elevation ? ValueOr(scan.elevation_rad, index, 0.0) : 0.0,
      .azimuth_rad = scan.azimuth_rad[index],
      .range_sigma_m = ValueOr(scan.range_sigma_m, index, radar.range_sigma_m),
      .range_rate_sigma_mps = ValueOr(scan.range_rate_sigma_mps, index, radar.range_rate_sigma_mps),
      .elevation_sigma_rad = ValueOr(scan.elevation_sigma_rad, index, radar.elevation_sigma_rad),
      .azimuth_sigma_rad = ValueOr(scan.azimuth_sigma_rad, index, radar.azimuth_sigma_rad),
  };
}

Eigen::Vector3d LineOfSight(double azimuth_rad, double elevation_rad) {
  const double cos_elevation = std::cos(elevation_rad);
  return {cos_elevation * std::cos(azimuth_rad), cos_elevation * std::sin(azimuth_rad),
          std::sin(elevation_rad)};
}

double CompensatedRange(double range_m, double range_rate_mps, double beta_s) {  // METHOD eq 6
  return range_m - beta_s * range_rate_mps;
}

double PredictedRangeRate(const Eigen::Vector3d& u_vehicle, const Pose3& T_vehicle_radar,
                          const EgoVelocity& ego_velocity) {  // METHOD eq 20
  const Eigen::Vector3d v_sensor =
      ego_velocity.linear_mps + ego_velocity.angular_radps.cross(T_vehicle_radar.translation_m);
  return -u_vehicle.dot(v_sensor);
}

Eigen::Vector3d PointInRadar(const Measurement& measurement, double beta_s) {  // METHOD eq 9
  return CompensatedRange(measurement.range_m, measurement.range_rate_mps, beta_s) *
         LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
}

Eigen::Matrix<double, 3, 4> PointJacobian(const Measurement& measurement, double beta_s) {
  const double cos_azimuth = std::cos(measurement.azimuth_rad);
  const double sin_azimuth = std::sin(measurement.azimuth_rad);
  const double cos_elevation = std::cos(measurement.elevation_rad);
  const double sin_elevation = std::sin(measurement.elevation_rad);
  const double range_m = CompensatedRange(measurement.range_m, measurement.range_rate_mps, beta_s);
  const Eigen::Vector3d u = LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
  Eigen::Matrix<double, 3, 4> jacobian;
  jacobian.col(0) = u;
  jacobian.col(1) = -beta_s * u;
  jacobian.col(2) = range_m * Eigen::Vector3d(-sin_elevation * cos_azimuth,
                                              -sin_elevation * sin_azimuth, cos_elevation);
  jacobian.col(3) = range_m * cos_elevation * Eigen::Vector3d(-sin_azimuth, cos_azimuth, 0.0);
  return jacobian;
}

Eigen::Matrix3d PointCovariance(const Measurement& measurement, double beta_s) {  // METHOD eq 11
  const Eigen::Matrix<double, 3, 4> jacobian = PointJacobian(measurement, beta_s);
  const Eigen::Vector4d variances(
      measurement.range_sigma_m * measurement.range_sigma_m,
      measurement.range_rate_sigma_mps * measurement.range_rate_sigma_mps,
      measurement.elevation_sigma_rad * measurement.elevation_sigma_rad,
      measurement.azimuth_sigma_rad * measurement.azimuth_sigma_rad);
  return jacobian * variances.asDiagonal() * jacobian.transpose();
}

}  // namespace dcloc
