#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose.h"

namespace dcloc {

/// One radar target, a row of the HDF5 file's "radar_data" (sensor coordinates).
struct RadarScenesTarget {
  std::int64_t timestamp_us;
  std::int64_t sensor_id;
  float range_m;
  float azimuth_rad;
  float rcs_dbsm;
  float range_rate_mps;
};

/// One row of "odometry".
struct RadarScenesOdometry {
  std::int64_t timestamp_us;
  float x_m;
  float y_m;
  float yaw_rad;
  float vx_mps;
  float yaw_rate_radps;
};

/// One radar's measurement: the rows [begin, end) of the targets.
struct RadarScenesScene {
  std::int64_t timestamp_us = 0;
  std::int64_t sensor_id = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

absl::StatusOr<std::vector<RadarScenesTarget>> ReadRadarScenesTargets(
    const std::filesystem::path& radar_data_h5);

/// Rows by ascending timestamp.
absl::StatusOr<std::vector<RadarScenesOdometry>> ReadRadarScenesOdometry(
    const std::filesystem::path& radar_data_h5);

/// Mounts of the radars by id, from sensors.json.
absl::StatusOr<std::map<std::int64_t, Pose3>> ReadRadarScenesMounts(
    const std::filesystem::path& sensors_json);

/// The scenes of scenes.json by ascending timestamp.
absl::StatusOr<std::vector<RadarScenesScene>> ReadRadarScenesScenes(
    const std::filesystem::path& scenes_json);

}  // namespace dcloc
