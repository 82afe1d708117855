#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/core/radar/scan_fixture.h"

namespace dcloc {

/// A drive whose radars stamp their scans late, or whose vehicle reports its velocity late.
struct LateDrive {
  std::vector<double> late_s;       ///< by radar of the rig
  double reported_late_s = 0.0;     ///< of the vehicle's own velocity
  double scale = 1.0;               ///< of the vehicle's own speed
  double range_rate_scale = 1.0;    ///< of all radars
  double range_rate_error_mps = 0;  ///< of all targets of a scan alike
  std::function<double(double)> speed_mps = [](double t_s) {
    return 11.0 + 3.0 * std::sin(0.25 * t_s) + std::sin(0.9 * t_s);
  };
  std::function<double(double)> yaw_rate_radps = [](double t_s) {
    return 0.15 * std::sin(0.4 * t_s);
  };
};

/// A front and a rear radar.
inline Rig FrontAndRear() {
  return {.radars = {RadarAt("front", 3.6, 0.0, 0.0), RadarAt("rear", -1.0, 0.3, 3.14)}};
}

/// Gives `on_scan` (scan, index of its radar) the scans of `drive` over `duration_s`, in the order
/// of their stamps; radars take turns every 35 ms.
inline void ForEachScan(const Rig& rig, const LateDrive& drive, double duration_s,
                        const std::function<void(const Scan&, std::size_t)>& on_scan) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto velocity_at = [&](double t_s) {
    return EgoVelocity{.linear_mps = {drive.speed_mps(t_s), 0.0, 0.0},
                       .angular_radps = {0.0, 0.0, drive.yaw_rate_radps(t_s)}};
  };
  unsigned count = 0;
  for (int ms = 1000; ms < 1000.0 * (1.0 + duration_s); ms += 35, ++count) {
    const std::size_t index = count % rig.radars.size();
    const double t_s = 1e-3 * ms;
    Scan scan =
        StaticScan(rig.radars[index], velocity_at(t_s - drive.late_s[index]), 60, count, 1.0);
    const double error_mps = drive.range_rate_error_mps * normal(random);
    for (float& range_rate_mps : scan.range_rate_mps) {
      range_rate_mps = static_cast<float>(drive.range_rate_scale * range_rate_mps + error_mps);
    }
    scan.stamp = Stamp(std::chrono::milliseconds(ms));
    scan.ego_velocity = velocity_at(t_s - drive.reported_late_s);
    scan.ego_velocity->linear_mps.x() *= drive.scale;
    scan.ego_velocity->linear_mps.x() += 0.02 * normal(random);
    scan.ego_velocity->angular_radps.z() += 0.001 * normal(random);
    on_scan(scan, index);
  }
}

}  // namespace dcloc
