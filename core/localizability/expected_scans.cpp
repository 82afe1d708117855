#include "core/localizability/expected_scans.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace dcloc {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kReach_m = 50.0;  // from a keyframe to its landmarks, and to a vehicle near it

/// A square root of a covariance, which may be singular.
Eigen::Matrix3d SpreadOf(const MapPoint& point) {
  Eigen::Matrix3d covariance;
  covariance << point.xx_m2, point.xy_m2, point.xz_m2,  //
      point.xy_m2, point.yy_m2, point.yz_m2,            //
      point.xz_m2, point.yz_m2, point.zz_m2;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace

std::span<const OptionField<ExpectedScanOptions>> FieldsOf(const ExpectedScanOptions& /*options*/) {
  using O = ExpectedScanOptions;
  static constexpr OptionField<O> kFields[] = {
      {"landmark_targets", &O::landmark_targets, 1, 10'000},
      {"max_hit_probability", &O::max_hit_probability, 0.01, 1},
      {"unmapped_share", &O::unmapped_share, 0, 0.9, "the map holds all that is there"},
      {"max_range_m", &O::max_range_m, 5, 1000},
      {"half_field_of_view_rad", &O::half_field_of_view_rad, 0.05, kPi},
      {"wall_m", &O::wall_m, 0, 100, "walls look like posts"},
  };
  return kFields;
}

absl::Status Validate(const ExpectedScanOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

Scan ExpectedScans::At(const RadarModel& radar, const Pose3& T_map_vehicle,
                       const EgoVelocity& velocity, Stamp stamp) {
  GatherAround(T_map_vehicle.translation_m);
  const Pose3 T_radar_map = (T_map_vehicle * radar.T_vehicle_radar).Inverse();
  const Eigen::Vector3d velocity_mps =
      radar.T_vehicle_radar.rotation.conjugate() *
      (velocity.linear_mps + velocity.angular_radps.cross(radar.T_vehicle_radar.translation_m));
  const bool is_spatial = map_->info().has_elevation && radar.has_elevation;
  echoes_.clear();
  double weight = 0.0;
  for (const Scatterer& scatterer : scatterers_) {
    const double along_wall = 2.0 * uniform_(random_) - 1.0;
    Eigen::Vector3d p_radar_m =
        T_radar_map * Eigen::Vector3d(scatterer.p_map_m + scatterer.spread_map_m * Normal() +
                                      along_wall * scatterer.wall_map_m);
    if (!is_spatial) p_radar_m.z() = scatterer.height_m.value_or(0.0);
    if (!IsInView(p_radar_m)) continue;
    echoes_.push_back({p_radar_m, scatterer.weight});
    weight += scatterer.weight;
  }
  Scan scan{.stamp = stamp, .radar_id = radar.id};
  for (const Echo& echo : echoes_) {
    const double probability =
        std::min(options_.max_hit_probability, options_.landmark_targets * echo.weight / weight);
    if (uniform_(random_) < probability) Measure(radar, echo.p_radar_m, velocity_mps, scan);
  }
  const double unmapped = static_cast<double>(scan.size()) * options_.unmapped_share /
                          std::max(1.0 - options_.unmapped_share, 0.01);
  for (int i = 0; i < static_cast<int>(unmapped); ++i) {
    const double range_m = options_.max_range_m * std::sqrt(0.01 + 0.99 * uniform_(random_));
    const double azimuth_rad = options_.half_field_of_view_rad * (2.0 * uniform_(random_) - 1.0);
    Measure(radar, range_m * Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0),
            velocity_mps, scan);
  }
  return scan;
}

void ExpectedScans::GatherAround(const Eigen::Vector3d& p_map_m) {
  const std::optional<std::size_t> nearest = map_->NearestKeyframe(p_map_m, kReach_m);
  if (nearest && nearest == keyframe_) return;
  keyframe_ = nearest;
  scatterers_.clear();
  const MapInfo& info = map_->info();
  for (const std::size_t index : map_->KeyframesWithin(p_map_m, options_.max_range_m + kReach_m)) {
    const Keyframe keyframe = map_->keyframe(index);
    const Eigen::Matrix3d rotation = keyframe.T_map_keyframe.Rotation();
    const double wall_m = !is_tunnel_.empty() && is_tunnel_[index] ? options_.wall_m : 0.0;
    for (const MapPoint& point : keyframe.points) {
      const Eigen::Vector3d p_keyframe_m(point.x_m, point.y_m, info.has_heights ? 0.0F : point.z_m);
      scatterers_.push_back(
          {.p_map_m = keyframe.T_map_keyframe * p_keyframe_m,
           .spread_map_m = rotation * SpreadOf(point),
           .height_m = info.has_heights ? std::optional<double>(point.z_m) : std::nullopt,
           .weight =
               std::max<double>(point.scan_count, 1.0) / std::max<double>(point.pass_count, 1.0),
           .wall_map_m = wall_m * rotation.col(0)});
    }
  }
}

Eigen::Vector3d ExpectedScans::Normal() {
  const double x = normal_(random_);
  const double y = normal_(random_);
  return {x, y, normal_(random_)};
}

bool ExpectedScans::IsInView(const Eigen::Vector3d& p_radar_m) const {
  return p_radar_m.norm() <= options_.max_range_m &&
         std::abs(std::atan2(p_radar_m.y(), p_radar_m.x())) <= options_.half_field_of_view_rad;
}

void ExpectedScans::Measure(const RadarModel& radar, const Eigen::Vector3d& p_radar_m,
                            const Eigen::Vector3d& velocity_mps, Scan& scan) {
  const double range_m = p_radar_m.norm();
  const double measured_m = range_m + radar.range_sigma_m * normal_(random_);
  if (measured_m <= 0.0) return;
  scan.range_m.push_back(static_cast<float>(measured_m));
  scan.range_rate_mps.push_back(static_cast<float>(-velocity_mps.dot(p_radar_m) / range_m +
                                                   radar.range_rate_sigma_mps * normal_(random_)));
  const double azimuth_rad =
      std::atan2(p_radar_m.y(), p_radar_m.x()) + radar.azimuth_sigma_rad * normal_(random_);
  scan.azimuth_rad.push_back(static_cast<float>(std::clamp(azimuth_rad, -kPi, kPi)));
  if (!radar.has_elevation) return;
  scan.elevation_rad.push_back(static_cast<float>(std::asin(p_radar_m.z() / range_m) +
                                                  radar.elevation_sigma_rad * normal_(random_)));
}

}  // namespace dcloc
