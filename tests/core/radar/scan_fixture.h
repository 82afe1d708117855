#pragma once

#include <cmath>
#include <random>

#include "core/radar/measurement.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// A scan of `count` static targets around the radar's boresight (+-60 degrees, 5-80 m), seen from
/// a vehicle moving with `ego`; exact but for normal noise of the radar's own deviations times
/// `noise_scale` on the range rate.
inline Scan StaticScan(const RadarModel& radar, const EgoVelocity& ego, int count, unsigned seed,
                       double noise_scale) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> azimuth(-1.05, 1.05);
  std::uniform_real_distribution<double> range(5.0, 80.0);
  std::normal_distribution<double> noise(0.0, radar.range_rate_sigma_mps * noise_scale);
  Scan scan;
  scan.radar_id = radar.id;
  for (int i = 0; i < count; ++i) {
    const double azimuth_rad = azimuth(random);
    const Eigen::Vector3d u = radar.T_vehicle_radar.Rotation() * LineOfSight(azimuth_rad, 0.0);
    double rate_mps = PredictedRangeRate(u, radar.T_vehicle_radar, ego) + noise(random);
    const double range_m = range(random) + radar.beta_s * rate_mps;
    if (radar.unambiguous_range_rate_mps > 0.0) {
      rate_mps = std::remainder(rate_mps, 2.0 * radar.unambiguous_range_rate_mps);
    }
    scan.azimuth_rad.push_back(static_cast<float>(azimuth_rad));
    scan.range_m.push_back(static_cast<float>(range_m));
    scan.range_rate_mps.push_back(static_cast<float>(rate_mps));
  }
  return scan;
}

/// A radar at (x, y) of the vehicle that looks to `yaw_rad`.
inline RadarModel RadarAt(const char* id, double x_m, double y_m, double yaw_rad) {
  RadarModel radar{.id = id};
  radar.T_vehicle_radar = Embed(Pose2{.translation_m = {x_m, y_m}, .yaw_rad = yaw_rad});
  return radar;
}

}  // namespace dcloc
