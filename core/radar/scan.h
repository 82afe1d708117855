#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// What wheels and gyroscope said at one moment.
struct MotionTick {
  std::chrono::nanoseconds after_scan{0};  ///< since the stamp of the scan; negative before it
  double speed_mps = 0.0;                  ///< forward, of the vehicle frame's origin
  double yaw_rate_radps = 0.0;
};

/// One radar scan: columns of equal length, one row a target, in the radar's own polar frame
/// (x forward, y left, z up; azimuth counter-clockwise from x, elevation up from the xy plane).
struct Scan {
  Stamp stamp;
  std::string radar_id;

  std::vector<float> range_m;         ///< as measured, not compensated; > 0
  std::vector<float> range_rate_mps;  ///< positive when the target recedes
  std::vector<float> azimuth_rad;
  std::vector<float> elevation_rad;  ///< empty when the radar does not measure it
  std::vector<float> rcs_dbsm;       ///< empty when unknown

  /// Standard deviations per target; empty columns fall back on the radar model's.
  std::vector<float> range_sigma_m;
  std::vector<float> range_rate_sigma_mps;
  std::vector<float> azimuth_sigma_rad;
  std::vector<float> elevation_sigma_rad;

  /// From wheels and gyroscope, at the scan's stamp; absent when the vehicle has none.
  std::optional<EgoVelocity> ego_velocity;

  /// Around the time since the scan before it, in the order of time; empty when the vehicle sends
  /// none.
  std::vector<MotionTick> ticks;

  std::size_t size() const { return range_m.size(); }
};

/// Bounds on what a scan may contain; beyond them it is refused as a whole.
struct ScanLimits {
  std::size_t max_targets = 20'000;
  double max_range_m = 1'000.0;
  double max_range_rate_mps = 200.0;
  double max_speed_mps = 150.0;
  double max_turn_rate_radps = 10.0;
  std::size_t max_ticks = 1'000;
  std::chrono::nanoseconds max_tick_age = std::chrono::seconds(2);  ///< before or after the scan
  double max_variance = 1e12;  ///< of a velocity, in its units squared
  Stamp min_stamp{};           ///< the year 1970
  Stamp max_stamp = kMaxStamp;
};

/// OK, or InvalidArgument that names the column, the row, the value and the bound. Checks lengths,
/// finiteness and ranges; an empty scan is valid (a radar that saw nothing).
absl::Status Validate(const Scan& scan, const ScanLimits& limits = {});

/// OK, or InvalidArgument naming what is wrong with a velocity or its covariance.
absl::Status Validate(const EgoVelocity& ego_velocity, const ScanLimits& limits = {});

}  // namespace dcloc
