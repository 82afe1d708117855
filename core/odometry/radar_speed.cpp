#include "core/odometry/radar_speed.h"

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
    rows_.push_back({.cosine = u_vehicle.x(),
                     .speed_mps = u_vehicle.x() * speed_mps + predicted_mps - range_rate_mps});
  }
  double found_mps = speed_mps;
  double last_step_mps = 0.0;
  double step_mps = 0.0;
  for (int iteration = 0; iteration < options_.iteration_count; ++iteration) {
    const double per_scale = 1.0 / (options_.residual_scale_mps * (iteration == 0   ? 4.0
                                                                   : iteration == 1 ? 2.0
                                                                                    : 1.0));
    double information = 0.0;
    double sum = 0.0;
    for (const Row& row : rows_) {
      const double residual = (row.speed_mps - row.cosine * found_mps) * per_scale;
      const double weighted = row.cosine / (1.0 + residual * residual);
      information += weighted * row.cosine;
      sum += weighted * row.speed_mps;
    }
    if (information < options_.min_information) return std::nullopt;
    last_step_mps = step_mps;
    step_mps = sum / information - found_mps;
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
