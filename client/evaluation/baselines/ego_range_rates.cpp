#include "client/evaluation/baselines/ego_range_rates.h"

#include <cstddef>
#include <utility>

#include "core/odometry/ego_motion.h"
#include "core/radar/measurement.h"

namespace dcloc {

Scan WithEgoRangeRates(Scan scan, const RadarModel& radar, const EgoVelocity& ego_velocity) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Measurement measurement = MeasurementAt(scan, i, radar);
    const Eigen::Vector3d u_vehicle =
        radar.T_vehicle_radar.rotation *
        LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
    scan.range_rate_mps[i] =
        static_cast<float>(PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, ego_velocity));
  }
  return scan;
}

Drive WithEgoRangeRates(Drive drive) {
  EgoMotion ego_motion;
  for (DriveScan& entry : drive.scans) {
    const RadarModel& radar = *drive.rig.Find(entry.scan.radar_id);
    const EgoVelocity velocity = ego_motion.Advance(entry.scan, radar);
    entry.scan = WithEgoRangeRates(std::move(entry.scan), radar, velocity);
  }
  return drive;
}

}  // namespace dcloc
