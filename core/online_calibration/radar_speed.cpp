#include "core/online_calibration/radar_speed.h"

#include <algorithm>
#include <cmath>

#include "core/radar/measurement.h"

namespace dcloc {
namespace {

constexpr double kMaxStepRatio = 0.8;

}  // namespace

std::span<const OptionField<RadarSpeedOptions>> FieldsOf(const RadarSpeedOptions& /*options*/) {
  using O = RadarSpeedOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_target_count", &O::max_target_count, 4, 20'000},
      {"min_cosine", &O::min_cosine, 0, 1, "all targets are used"},
      {"residual_scale_mps", &O::residual_scale_mps, 1e-6, 100},
      {"iteration_count", &O::iteration_count, 3, 100},
      {"lateral_sigma_mps", &O::lateral_sigma_mps, 1e-3, 100},
      {"min_information", &O::min_information, 1e-6, 20'000},
      {"max_difference_mps", &O::max_difference_mps, 1e-6, 100},
  };
  return kFields;
}

absl::Status Validate(const RadarSpeedOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<double> RadarSpeed::Of(const Scan& scan, const RadarModel& radar,
                                     const EgoVelocity& reported) {
  rows_.clear();
  const auto limit = static_cast<std::size_t>(options_.max_target_count);
  const std::size_t stride = (scan.size() + limit - 1) / limit;
  const Eigen::Matrix3d R_vehicle_radar = radar.T_vehicle_radar.Rotation();
  const double speed_mps = reported.linear_mps.x();
  for (std::size_t i = 0; i < scan.size(); i += stride) {
    const Measurement measurement = MeasurementAt(scan, i, radar);
    const Eigen::Vector3d u_vehicle =
        R_vehicle_radar * LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
    if (std::abs(u_vehicle.x()) < options_.min_cosine) continue;
    const double predicted_mps = PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, reported);
    const double range_rate_mps = UnfoldRangeRate(measurement.range_rate_mps, predicted_mps,
                                                  radar.unambiguous_range_rate_mps);
    rows_.push_back(
        {.ahead = u_vehicle.x(),
         .left = u_vehicle.y(),
         .approaching_mps = u_vehicle.x() * speed_mps + predicted_mps - range_rate_mps});
  }
  double found_mps = speed_mps;
  double lateral_mps = 0.0;
  double last_step_mps = 0.0;
  double step_mps = 0.0;
  const double lateral_information =
      std::pow(options_.residual_scale_mps / options_.lateral_sigma_mps, 2);
  for (int iteration = 0; iteration < options_.iteration_count; ++iteration) {
    const double per_scale = 1.0 / (options_.residual_scale_mps * (iteration == 0   ? 4.0
                                                                   : iteration == 1 ? 2.0
                                                                                    : 1.0));
    double xx = 0.0, xy = 0.0, yy = lateral_information, xq = 0.0, yq = 0.0;
    for (const Row& row : rows_) {
      const double residual =
          (row.approaching_mps - row.ahead * found_mps - row.left * lateral_mps) * per_scale;
      const double weight = 1.0 / (1.0 + residual * residual);
      xx += weight * row.ahead * row.ahead;
      xy += weight * row.ahead * row.left;
      yy += weight * row.left * row.left;
      xq += weight * row.ahead * row.approaching_mps;
      yq += weight * row.left * row.approaching_mps;
    }
    const double determinant = xx * yy - xy * xy;
    if (determinant < options_.min_information * yy) return std::nullopt;
    last_step_mps = step_mps;
    step_mps = (yy * xq - xy * yq) / determinant - found_mps;
    lateral_mps = (xx * yq - xy * xq) / determinant;
    found_mps += step_mps;
  }
  // The steps shrink by about one factor. What is left of them would pull all delays towards none.
  if (last_step_mps != 0.0) {
    const double ratio = std::clamp(step_mps / last_step_mps, 0.0, kMaxStepRatio);
    found_mps += step_mps * ratio / (1.0 - ratio);
  }
  if (std::abs(found_mps - speed_mps) > options_.max_difference_mps) return std::nullopt;
  return found_mps;
}

}  // namespace dcloc
