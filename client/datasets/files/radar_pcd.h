#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"

namespace dcloc {

/// One target of a nuScenes radar sweep, in the sensor's frame (x forward, y left, z up). The
/// integer codes are the nuScenes devkit's.
struct RadarPcdTarget {
  float x_m = 0.0F;
  float y_m = 0.0F;
  float z_m = 0.0F;
  float rcs_dbsm = 0.0F;
  /// Velocity relative to the moving sensor.
  float vx_mps = 0.0F;
  float vy_mps = 0.0F;
  int dyn_prop = 0;
  int ambig_state = 0;
  int invalid_state = 0;
};

/// Reads a binary PCD v0.7 file of radar targets: the nine fields above, by name and in any order,
/// beside whatever other fields it holds. Rows with a NaN among them (a sweep without targets is
/// one such row) are left out. DataLoss names the file and what is wrong with it.
absl::StatusOr<std::vector<RadarPcdTarget>> ReadRadarPcd(const std::filesystem::path& path);

}  // namespace dcloc
