#include "core/radar/static_points.h"

#include <cmath>
#include <cstddef>

#include "core/radar/measurement.h"

namespace dcloc {
namespace {

// What every point is given when covariances of their own are switched off.
constexpr double kUniformSigma_m = 0.3;

// Spread of the range rate that the ego-motion predicts for a static target: the line of sight's
// own error turns the velocity, and an unmeasured elevation shortens it to second order.
double PredictionSigma(const Measurement& measurement, const Eigen::Vector3d& u_vehicle,
                       const Pose3& T_vehicle_radar, const EgoVelocity& ego_velocity) {
  const Eigen::Vector3d v_sensor =
      ego_velocity.linear_mps + ego_velocity.angular_radps.cross(T_vehicle_radar.translation_m);
  const double along_mps = u_vehicle.dot(v_sensor);
  const double across_mps = (v_sensor - along_mps * u_vehicle).norm();
  double variance = std::pow(across_mps * measurement.azimuth_sigma_rad, 2) +
                    std::pow(0.5 * along_mps * std::pow(measurement.elevation_sigma_rad, 2), 2);
  if (ego_velocity.covariance) {
    Vector6d row;
    row << u_vehicle, T_vehicle_radar.translation_m.cross(u_vehicle);
    variance += row.dot(*ego_velocity.covariance * row);
  }
  return std::sqrt(variance);
}

Eigen::Vector2d SlantPerMetre(const Measurement& measurement, const Eigen::Vector3d& u_vehicle,
                              const RadarModel& radar) {  // METHOD eq 25
  if (radar.has_elevation) return Eigen::Vector2d::Zero();
  return u_vehicle.head<2>() / (2.0 * measurement.range_m);
}

}  // namespace

Pose3 MountAtStamp(const RadarModel& radar, const EgoVelocity& ego_velocity) {
  if (radar.time_offset_s == 0.0) return radar.T_vehicle_radar;
  Vector6d twist;
  twist << ego_velocity.linear_mps, ego_velocity.angular_radps;
  return Exp(Vector6d(radar.time_offset_s * twist)) * radar.T_vehicle_radar;
}

std::span<const OptionField<StaticPointsOptions>> FieldsOf(const StaticPointsOptions& /*options*/) {
  using O = StaticPointsOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_range_m", &O::min_range_m, 0, 1000, "targets on the vehicle itself are used"},
      {"max_range_m", &O::max_range_m, 0, 1000, "only targets at no range are used"},
      {"static_gate_mps", &O::static_gate_mps, 0, 100, "the gate is the prediction's spread alone"},
      {"static_gate_sigmas", &O::static_gate_sigmas, 0, 100, "the gate is static_gate_mps alone"},
  };
  return kFields;
}

absl::Status Validate(const StaticPointsOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  if (status.ok() && options.max_range_m < options.min_range_m) {
    status = absl::InvalidArgumentError(
        absl::StrFormat("max_range_m is %g; it must not lie below min_range_m, %g",
                        options.max_range_m, options.min_range_m));
  }
  return status;
}

std::vector<RadarPoint> StaticPoints(const Scan& scan, const RadarModel& radar,
                                     const EgoVelocity& ego_velocity,
                                     const StaticPointsOptions& options) {
  std::vector<RadarPoint> points;
  StaticPoints(scan, radar, ego_velocity, options, points);
  return points;
}

void StaticPoints(const Scan& scan, const RadarModel& radar, const EgoVelocity& ego_velocity,
                  const StaticPointsOptions& options, std::vector<RadarPoint>& points) {
  const Eigen::Matrix3d R_vehicle_radar = radar.T_vehicle_radar.Rotation();
  const Pose3 T_stamp_radar = MountAtStamp(radar, ego_velocity);
  const double beta_s = options.compensate ? radar.beta_s : 0.0;
  points.clear();
  points.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    Measurement measurement = MeasurementAt(scan, i, radar);
    if (measurement.range_m < options.min_range_m || measurement.range_m > options.max_range_m) {
      continue;
    }
    const Eigen::Vector3d u_vehicle =
        R_vehicle_radar * LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
    const double predicted_mps = PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, ego_velocity);
    measurement.range_rate_mps = UnfoldRangeRate(measurement.range_rate_mps, predicted_mps,
                                                 radar.unambiguous_range_rate_mps);
    const double sigma_mps =
        std::hypot(measurement.range_rate_sigma_mps,
                   PredictionSigma(measurement, u_vehicle, radar.T_vehicle_radar, ego_velocity));
    if (std::abs(measurement.range_rate_mps - predicted_mps) >
        options.static_gate_mps + options.static_gate_sigmas * sigma_mps) {
      continue;
    }
    const Eigen::Matrix3d covariance =
        options.per_point_covariance
            ? Eigen::Matrix3d(R_vehicle_radar * PointCovariance(measurement, beta_s) *
                              R_vehicle_radar.transpose())
            : Eigen::Matrix3d(kUniformSigma_m * kUniformSigma_m * Eigen::Matrix3d::Identity());
    points.push_back({.position_m = T_stamp_radar * PointInRadar(measurement, beta_s),
                      .covariance_m2 = covariance,
                      .rcs_dbsm = scan.rcs_dbsm.empty() ? 0.0F : scan.rcs_dbsm[i],
                      .slant_per_m = SlantPerMetre(measurement, u_vehicle, radar)});
  }
}

}  // namespace dcloc
