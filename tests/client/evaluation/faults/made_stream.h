#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "client/evaluation/faults/stream.h"

namespace dcloc::faults {

/// The time of a made stream's scan `seconds` after its first.
inline Stamp MadeStamp(double seconds) { return Stamp(std::chrono::hours(1)) + Duration(seconds); }

/// A drive of `seconds` along x at 10 m/s, ten scans a second of each of `radar_count` radars
/// (named "a", "b", ..., 20 ms apart, all looking ahead). Each scan has ten targets, to both sides,
/// and a velocity that grows by 0.1 m/s and 0.01 rad/s a second.
inline Drive MadeDrive(double seconds, int radar_count = 1) {
  Drive drive{.name = "made", .place = "", .rig = {}, .scans = {}};
  for (int radar = 0; radar < radar_count; ++radar) {
    drive.rig.radars.push_back({.id = std::string(1, static_cast<char>('a' + radar))});
  }
  const int cycles = static_cast<int>(seconds * 10.0);
  for (int cycle = 0; cycle < cycles; ++cycle) {
    for (int radar = 0; radar < radar_count; ++radar) {
      const double t_s = 0.1 * cycle + 0.02 * radar;
      DriveScan& entry = drive.scans.emplace_back();
      entry.scan.stamp = MadeStamp(t_s);
      entry.scan.radar_id = drive.rig.radars[static_cast<std::size_t>(radar)].id;
      for (int row = 0; row < 10; ++row) {
        entry.scan.range_m.push_back(20.0F + static_cast<float>(row));
        entry.scan.azimuth_rad.push_back(0.1F * static_cast<float>(row) - 0.45F);
        entry.scan.range_rate_mps.push_back(-9.0F);
      }
      EgoVelocity velocity;
      velocity.linear_mps.x() = 10.0 + 0.1 * t_s;
      velocity.angular_radps.z() = 0.01 * t_s;
      entry.scan.ego_velocity = velocity;
      entry.T_map_vehicle.translation_m.x() = 10.0 * t_s;
    }
  }
  return drive;
}

/// The same as a stream, its prior at the first pose.
inline Stream MadeStream(double seconds, int radar_count = 1) {
  const Drive drive = MadeDrive(seconds, radar_count);
  return StreamOf(drive, {drive.scans.front().T_map_vehicle, Matrix6d::Identity()});
}

}  // namespace dcloc::faults
