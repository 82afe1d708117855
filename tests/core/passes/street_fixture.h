#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/map/editable_map.h"
#include "core/map/map_builder.h"
#include "core/passes/placed_pass.h"

namespace dcloc {

/// A straight street along x with scatterers beside it, and passes of a vehicle with one front
/// radar whose poses are known. Scans are of 10 Hz at 10 m/s.
struct TestStreet {
  static constexpr double kLength_m = 200.0;
  std::vector<Eigen::Vector2d> scatterers_m;

  TestStreet() {
    for (int i = 0; 4.0 * i <= kLength_m; ++i) {
      scatterers_m.emplace_back(4.0 * i, 6.0);
      scatterers_m.emplace_back(4.0 * i + 1.7, -7.0);
    }
  }

  static Rig OneRadar() {
    return {.radars = {{.id = "front", .T_vehicle_radar = {.translation_m = {3.5, 0.0, 0.5}}}}};
  }

  static Pose3 PoseAt(double x_m) { return {.translation_m = {x_m, 0.0, 0.0}}; }

  /// What the radar measures at `T_map_vehicle`: within 40 m and 60 degrees, nine times of ten.
  Scan See(const Pose3& T_map_vehicle, Stamp stamp, std::mt19937& random) const {
    Scan scan{.stamp = stamp, .radar_id = "front"};
    const Pose3 T_radar_map = (T_map_vehicle * OneRadar().radars[0].T_vehicle_radar).Inverse();
    std::normal_distribution<double> noise;
    std::uniform_real_distribution<double> chance;
    for (const Eigen::Vector2d& p_m : scatterers_m) {
      const Eigen::Vector3d p_radar = T_radar_map * Eigen::Vector3d(p_m.x(), p_m.y(), 0.5);
      const double azimuth_rad = std::atan2(p_radar.y(), p_radar.x());
      const bool is_seen = chance(random) < 0.9;
      if (p_radar.norm() > 40.0 || std::abs(azimuth_rad) > 1.05 || !is_seen) continue;
      scan.range_m.push_back(static_cast<float>(p_radar.norm() + 0.05 * noise(random)));
      scan.azimuth_rad.push_back(static_cast<float>(azimuth_rad + 0.005 * noise(random)));
      scan.range_rate_mps.push_back(static_cast<float>(-10.0 * p_radar.x() / p_radar.norm()));
    }
    scan.ego_velocity.emplace();
    scan.ego_velocity->linear_mps.x() = 10.0;
    return scan;
  }

  static Stamp StampOf(int day, int number) {
    return Stamp(std::chrono::days(20000 + day)) + std::chrono::milliseconds(100 * number);
  }

  std::vector<Scan> Drive(int day, std::vector<Pose3>* T_map_vehicles = nullptr) const {
    std::mt19937 random(static_cast<std::uint32_t>(17 + day));
    std::vector<Scan> scans;
    for (int i = 0; i <= static_cast<int>(kLength_m); ++i) {
      scans.push_back(See(PoseAt(i), StampOf(day, i), random));
      if (T_map_vehicles != nullptr) T_map_vehicles->push_back(PoseAt(i));
    }
    return scans;
  }

  EditableMap Map(int day) const {
    auto builder = MapBuilder::Create(OneRadar(), {.name = "street"}).value();
    std::vector<Pose3> poses;
    const std::vector<Scan> scans = Drive(day, &poses);
    for (std::size_t i = 0; i < scans.size(); ++i) {
      EXPECT_TRUE(builder.Add(scans[i], poses[i], *scans[i].ego_velocity).ok());
    }
    return ToEditable(*RadarMap::FromBytes(builder.Build().value()).value());
  }

  /// The map of the street's first part, until `kMappedEnd_m`.
  static constexpr double kMappedEnd_m = 100.0;
  EditableMap MapOfPart() const {
    EditableMap map = Map(0);
    const double origin_m = map.Origin_m().x();
    std::erase_if(map.keyframes, [&](const EditableKeyframe& keyframe) {
      return PoseOf(keyframe.record).translation_m.x() + origin_m > kMappedEnd_m;
    });
    return map;
  }

  /// A pass at its true poses, moved by `offset_m`, of which all scans count.
  PlacedPass Pass(int day, const std::string& vehicle,
                  const Eigen::Vector3d& offset_m = Eigen::Vector3d::Zero()) const {
    PlacedPass pass{.name = "day-" + std::to_string(day), .vehicle = vehicle, .rig = OneRadar()};
    std::vector<Pose3> poses;
    for (const Scan& scan : Drive(day, &poses)) {
      Pose3 T_map_vehicle = poses[pass.scans.size()];
      T_map_vehicle.translation_m += offset_m;
      pass.scans.push_back(
          {.stamp = scan.stamp,
           .T_map_vehicle = T_map_vehicle,
           .T_start_vehicle = Flatten(T_map_vehicle),
           .inlier_count = 50,
           .is_good = true,
           .points = StaticPoints(scan, pass.rig.radars[0], *scan.ego_velocity, {})});
    }
    pass.length_m = kLength_m;
    return pass;
  }
};

}  // namespace dcloc
