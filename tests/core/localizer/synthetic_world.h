#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/geometry/covariance.h"
#include "core/localizer/localizer.h"
#include "core/map/map_builder.h"
#include "core/map/radar_map.h"
#include "core/radar/measurement.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// A road in a bend with scatterers at random places on both of its sides; made by the test, so
/// that every truth is known.
struct SyntheticWorld {
  static constexpr double kBendRadius_m = 250.0;
  static constexpr double kLength_m = 160.0;
  std::vector<Eigen::Vector3d> scatterers_m;

  /// Scatterers up to `height_m` above the ground; 0 puts them at the radars' height.
  explicit SyntheticWorld(double height_m = 0.0) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> along_m(-30.0, kLength_m + 70.0);
    std::uniform_real_distribution<double> aside_m(3.0, 25.0);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 320; ++i) {
      const Pose3 T_map_road = OnRoad(along_m(random));
      const double side = unit(random) < 0.5 ? -1.0 : 1.0;
      scatterers_m.push_back(T_map_road *
                             Eigen::Vector3d(0.0, side * aside_m(random), height_m * unit(random)));
    }
  }

  /// Posts at even distances along both sides of the road.
  static SyntheticWorld Posts(double spacing_m) {
    SyntheticWorld world;
    world.scatterers_m.clear();
    const int count = static_cast<int>((kLength_m + 100.0) / spacing_m);
    for (int i = 0; i < count; ++i) {
      for (const double aside_m : {-5.0, 5.0}) {
        world.scatterers_m.push_back(OnRoad(-30.0 + i * spacing_m) *
                                     Eigen::Vector3d(0.0, aside_m, 0.0));
      }
    }
    return world;
  }

  /// The vehicle's pose `along_m` along the road.
  static Pose3 OnRoad(double along_m) {
    const double yaw_rad = along_m / kBendRadius_m;
    return Embed(Pose2{.translation_m = {kBendRadius_m * std::sin(yaw_rad),
                                         kBendRadius_m * (1.0 - std::cos(yaw_rad))},
                       .yaw_rad = yaw_rad});
  }

  static EgoVelocity VelocityAt(double speed_mps) {
    return {.linear_mps = {speed_mps, 0.0, 0.0},
            .angular_radps = {0.0, 0.0, speed_mps / kBendRadius_m}};
  }

  /// What `radar` sees from `T_map_vehicle`: four in ten of the scatterers within 60 m and 60
  /// degrees of its boresight, with the radar's own noise and Doppler shift.
  Scan See(const RadarModel& radar, const Pose3& T_map_vehicle, const EgoVelocity& ego, Stamp stamp,
           std::mt19937& random) const {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::normal_distribution<double> normal;
    const Pose3 T_radar_map = (T_map_vehicle * radar.T_vehicle_radar).Inverse();
    Scan scan{.stamp = stamp, .radar_id = radar.id};
    for (const Eigen::Vector3d& scatterer_m : scatterers_m) {
      const Eigen::Vector3d p_radar = T_radar_map * scatterer_m;
      const double range_m = p_radar.norm();
      const double azimuth_rad = std::atan2(p_radar.y(), p_radar.x());
      if (range_m > 60.0 || range_m < 2.0 || std::abs(azimuth_rad) > std::numbers::pi / 3.0) {
        continue;
      }
      if (unit(random) > 0.4) continue;
      const Eigen::Vector3d u_vehicle = radar.T_vehicle_radar.Rotation() * p_radar / range_m;
      const double rate_mps = PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, ego) +
                              radar.range_rate_sigma_mps * normal(random);
      scan.range_rate_mps.push_back(static_cast<float>(rate_mps));
      scan.range_m.push_back(static_cast<float>(range_m + radar.beta_s * rate_mps +
                                                radar.range_sigma_m * normal(random)));
      scan.azimuth_rad.push_back(
          static_cast<float>(azimuth_rad + radar.azimuth_sigma_rad * normal(random)));
      if (!radar.has_elevation) continue;
      scan.elevation_rad.push_back(static_cast<float>(std::asin(p_radar.z() / range_m) +
                                                      radar.elevation_sigma_rad * normal(random)));
    }
    return scan;
  }
};

/// A scan with where it was taken.
struct TrueScan {
  Scan scan;
  Pose3 T_map_vehicle;
};

/// One radar that looks ahead from the bumper.
inline Rig FrontRadar(double beta_s = 0.0, bool has_elevation = false) {
  RadarModel radar{.id = "front",
                   .beta_s = beta_s,
                   .range_sigma_m = 0.1,
                   .range_rate_sigma_mps = 0.1,
                   .azimuth_sigma_rad = 0.01,
                   .has_elevation = has_elevation};
  if (has_elevation) radar.elevation_sigma_rad = 0.01;
  radar.T_vehicle_radar.translation_m = {3.5, 0.0, 0.0};
  return {.radars = {radar}};
}

/// The whole road at one speed, each radar every 77 ms; scans carry the wheels' velocity.
inline std::vector<TrueScan> DriveRoad(const SyntheticWorld& world, const Rig& rig,
                                       double speed_mps, unsigned seed, int period_ms = 77) {
  std::mt19937 random(seed);
  std::vector<TrueScan> drive;
  const EgoVelocity ego = SyntheticWorld::VelocityAt(speed_mps);
  const double period_s = 1e-3 * period_ms;
  for (int i = 0; period_s * i * speed_mps < SyntheticWorld::kLength_m; ++i) {
    const Stamp stamp(std::chrono::seconds(1'700'000'000) +
                      std::chrono::milliseconds(period_ms * i));
    const Pose3 T_map_vehicle = SyntheticWorld::OnRoad(period_s * i * speed_mps);
    for (const RadarModel& radar : rig.radars) {
      Scan scan = world.See(radar, T_map_vehicle, ego, stamp, random);
      scan.ego_velocity = ego;
      drive.push_back({std::move(scan), T_map_vehicle});
    }
  }
  return drive;
}

/// The map of a drive at known poses.
inline std::shared_ptr<const RadarMap> MapOfDrive(const std::vector<TrueScan>& drive,
                                                  const Rig& rig,
                                                  const StaticPointsOptions& points = {}) {
  auto builder = MapBuilder::Create(rig, {.name = "bend", .static_points = points});
  EXPECT_TRUE(builder.ok()) << builder.status();
  for (const TrueScan& seen : drive) {
    const absl::Status added = builder->Add(seen.scan, seen.T_map_vehicle, *seen.scan.ego_velocity);
    EXPECT_TRUE(added.ok()) << added;
  }
  auto bytes = builder->Build();
  EXPECT_TRUE(bytes.ok()) << bytes.status();
  auto map = RadarMap::FromBytes(*std::move(bytes));
  EXPECT_TRUE(map.ok()) << map.status();
  return *std::move(map);
}

/// What is known before the first scan: `T_map_vehicle` with the same deviations in all directions.
inline InitialPose PriorAt(const Pose3& T_map_vehicle, double sigma_m, double sigma_rad) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(sigma_m * sigma_m),
      Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return {.T_map_vehicle = T_map_vehicle, .covariance = variances.asDiagonal()};
}

inline Localizer MakeLocalizer(std::shared_ptr<const RadarMap> map, Rig rig,
                               const std::optional<InitialPose>& prior,
                               const LocalizerOptions& options = {}) {
  auto localizer = Localizer::Create(std::move(map), std::move(rig), prior, options);
  EXPECT_TRUE(localizer.ok()) << localizer.status();
  return *std::move(localizer);
}

/// An answer with the truth.
struct TrueAnswer {
  Localization localization;
  Pose3 T_map_vehicle;

  double position_error_m() const {
    const Eigen::Vector3d error =
        localization.T_map_vehicle.translation_m - T_map_vehicle.translation_m;
    return error.head<2>().norm();
  }
  double yaw_error_rad() const {
    return std::abs(
        WrapAngle(Yaw(localization.T_map_vehicle.rotation) - Yaw(T_map_vehicle.rotation)));
  }
  bool tracking() const { return localization.state == LocalizationState::kTracking; }
};

inline std::vector<TrueAnswer> LocalizeDrive(Localizer localizer,
                                             const std::vector<TrueScan>& drive) {
  std::vector<TrueAnswer> answers;
  for (const TrueScan& seen : drive) {
    const auto answer = localizer.Localize(seen.scan);
    EXPECT_TRUE(answer.ok()) << answer.status();
    if (!answer.ok()) break;
    answers.push_back({*answer, seen.T_map_vehicle});
  }
  return answers;
}

/// Bit by bit, in everything.
inline void ExpectSame(const Localization& a, const Localization& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.T_map_vehicle.translation_m, b.T_map_vehicle.translation_m);
  EXPECT_EQ(a.T_map_vehicle.rotation.coeffs(), b.T_map_vehicle.rotation.coeffs());
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.observed, b.observed);
  EXPECT_EQ(a.quality.live_point_count, b.quality.live_point_count);
  EXPECT_EQ(a.quality.inlier_count, b.quality.inlier_count);
  EXPECT_EQ(a.quality.overlap, b.quality.overlap);
  EXPECT_EQ(a.quality.residual_scale, b.quality.residual_scale);
  EXPECT_EQ(a.quality.normalized_innovation_squared, b.quality.normalized_innovation_squared);
  EXPECT_EQ(a.quality.is_accepted, b.quality.is_accepted);
}

}  // namespace dcloc
