#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "client/evaluation/faults/stream.h"
#include "core/map/editable_map.h"

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

inline constexpr std::size_t kMadeLandmarks = 100;  ///< of each keyframe of a made map

/// A map of the way of a made stream, with a keyframe every 10 m. The landmarks of each have its
/// number as their distance ahead, and lie to the left.
inline std::shared_ptr<const RadarMap> MadeMap(std::size_t keyframe_count) {
  EditableMap map;
  map.name = "made";
  map.info.length_m = 10.0 * static_cast<double>(keyframe_count);
  map.info.index_cell_m = 25.0;
  for (std::size_t i = 0; i < keyframe_count; ++i) {
    EditableKeyframe& keyframe = map.keyframes.emplace_back();
    keyframe.record.translation_local_m[0] = 10.0 * static_cast<double>(i);
    keyframe.record.rotation_wxyz[0] = 1.0;
    for (std::size_t n = 1; n <= kMadeLandmarks; ++n) {
      keyframe.points.push_back({.x_m = static_cast<float>(i),
                                 .y_m = static_cast<float>(n),
                                 .xx_m2 = 1,
                                 .xy_m2 = 0.5F,
                                 .yy_m2 = 1,
                                 .zz_m2 = 1,
                                 .scan_count = 1,
                                 .pass_count = 1});
    }
  }
  return *RadarMap::FromBytes(*ToMapBytes(map));
}

}  // namespace dcloc::faults
