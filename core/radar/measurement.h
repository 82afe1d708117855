#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// One target's measured values and their standard deviations. The range is corrected for the
/// radar's bias, but not yet compensated. A deviation is the scan's column, or else the radar
/// model's.
struct Measurement {
  double range_m = 0.0;
  double range_rate_mps = 0.0;
  double elevation_rad = 0.0;
  double azimuth_rad = 0.0;
  double range_sigma_m = 0.0;
  double range_rate_sigma_mps = 0.0;
  double elevation_sigma_rad = 0.0;
  double azimuth_sigma_rad = 0.0;
};

/// Row `index` < scan.size() of a valid scan.
Measurement MeasurementAt(const Scan& scan, std::size_t index, const RadarModel& radar);

/// Unit line of sight u(azimuth, elevation) in the radar frame (METHOD 4).
Eigen::Vector3d LineOfSight(double azimuth_rad, double elevation_rad);

/// Range compensated for range-Doppler coupling: `r - beta v_r` (METHOD eq 6). `StaticPoints`
/// compensates whole scans.
double CompensatedRange(double range_m, double range_rate_mps, double beta_s);

/// Of all `range_rate_mps + 2 n unambiguous_mps` the one nearest to `predicted_mps`; the range rate
/// itself when `unambiguous_mps` is 0 (METHOD 1).
inline double UnfoldRangeRate(double range_rate_mps, double predicted_mps, double unambiguous_mps) {
  const double apart_mps = predicted_mps - range_rate_mps;
  if (std::abs(apart_mps) < unambiguous_mps || unambiguous_mps <= 0.0) return range_rate_mps;
  const double interval_mps = 2.0 * unambiguous_mps;
  return range_rate_mps + interval_mps * std::round(apart_mps / interval_mps);
}

/// Range rate of a static target at `u_vehicle` (unit, vehicle axes) seen by the radar at
/// `T_vehicle_radar`: `-u . (v + omega x l)`.
double PredictedRangeRate(const Eigen::Vector3d& u_vehicle, const Pose3& T_vehicle_radar,
                          const EgoVelocity& ego_velocity);

/// The target's position in the radar frame, its range compensated.
Eigen::Vector3d PointInRadar(const Measurement& measurement, double beta_s);

/// Jacobian of `PointInRadar` by (range, range rate, elevation, azimuth), in this order (METHOD eq
/// 10).
Eigen::Matrix<double, 3, 4> PointJacobian(const Measurement& measurement, double beta_s);

/// Covariance of `PointInRadar` [m^2] (METHOD eq 11).
Eigen::Matrix3d PointCovariance(const Measurement& measurement, double beta_s);

}  // namespace dcloc
