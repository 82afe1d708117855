#pragma once

#include <chrono>
#include <cmath>
#include <utility>

#include "client/datasets/drive.h"

namespace dcloc {

/// A rig of two radars drives at 10 m/s past things that stand all around it.
inline Drive TwoRadars() {
  Drive drive{.name = "drive"};
  for (const auto& [id, yaw] : {std::pair{"front", 0.7}, std::pair{"rear", -2.2}}) {
    RadarModel radar;
    radar.id = id;
    radar.beta_s = 0.04;
    radar.T_vehicle_radar = {{1.7, 0.3, 0.5},
                             Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()))};
    drive.rig.radars.push_back(radar);
  }
  for (int i = 0; i < 40; ++i) {
    const RadarModel& radar = drive.rig.radars[static_cast<std::size_t>(i % 2)];
    DriveScan entry;
    entry.scan.stamp =
        Stamp(std::chrono::nanoseconds(1'714'557'600'123'456'789 + i * 70'000'001LL));
    entry.scan.radar_id = radar.id;
    entry.T_map_vehicle = {
        {0.7 * i, 0.01 * i, 0.0},
        Eigen::Quaterniond(Eigen::AngleAxisd(0.01 * i, Eigen::Vector3d::UnitZ()))};
    entry.scan.ego_velocity = EgoVelocity{{10.0, 0.0, 0.0}, {0.0, 0.0, 0.1}, std::nullopt};
    if (i % 3 == 0) entry.scan.ego_velocity->covariance = 0.01 * Matrix6d::Identity();
    const Eigen::Vector3d v_radar = radar.T_vehicle_radar.rotation.conjugate() *
                                    Eigen::Vector3d(10.0 - 0.1 * 0.3, 0.1 * 1.7, 0.0);
    for (int k = 0; k < 30; ++k) {
      const double azimuth = -1.0 + k / 14.9;
      entry.scan.range_m.push_back(static_cast<float>(10.0 + k / 7.0));
      entry.scan.azimuth_rad.push_back(static_cast<float>(azimuth));
      entry.scan.range_rate_mps.push_back(
          static_cast<float>(-(v_radar.x() * std::cos(azimuth) + v_radar.y() * std::sin(azimuth))));
      entry.scan.rcs_dbsm.push_back(static_cast<float>(k));
    }
    drive.scans.push_back(std::move(entry));
  }
  return drive;
}

}  // namespace dcloc
