#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// A radar by its frame in the vehicle frame (x ahead, y left, z up).
struct MountedRadar {
  std::string radar_id;
  std::array<double, 3> translation_m{};
  double yaw_rad = 0.0;  ///< where it looks: counter-clockwise from straight ahead
  double beta_s = 0.0;   ///< range-Doppler coupling; 0 where the firmware compensates
};

/// What a radar measured of one target, in its own frame.
struct Target {
  float range_m = 0.0F;
  float azimuth_rad = 0.0F;     ///< counter-clockwise from the radar's x axis
  float range_rate_mps = 0.0F;  ///< positive away from the radar
};

/// The message that opens a session: the map of a name, and the radars that sit upright. All else
/// is in its fields: an initial pose, elevations, deviations.
v1::OpenSession OpenRequest(const std::string& vehicle_id, const std::string& map_name,
                            const std::vector<MountedRadar>& radars);

/// A scan of one radar, without a number.
v1::Scan ScanOf(const std::string& radar_id, std::int64_t stamp_ns,
                std::span<const Target> targets);

}  // namespace dcloc::client
