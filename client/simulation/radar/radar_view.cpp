#include "client/simulation/radar/radar_view.h"

#include <cmath>

namespace dcloc::simulation {

Observation RadarView::Observe(const Eigen::Vector3d& p_map,
                               const Eigen::Vector3d& velocity_map_mps) const {
  const Eigen::Vector3d sight_map = p_map - T_map_radar.translation_m;
  const Eigen::Vector3d p_radar = T_map_radar.rotation.conjugate() * sight_map;
  const double range_m = sight_map.norm();
  return {range_m, std::atan2(p_radar.y(), p_radar.x()),
          std::atan2(p_radar.z(), p_radar.head<2>().norm()),
          sight_map.dot(velocity_map_mps - velocity_mps) / range_m};
}

RadarView ViewFrom(const MotionState& motion, const Pose3& T_vehicle_radar) {
  const Pose3 T_map_vehicle = Embed(motion.T_map_vehicle);
  const Eigen::Vector3d lever = T_vehicle_radar.translation_m;
  const Eigen::Vector3d velocity_vehicle(motion.speed_mps - motion.yaw_rate_radps * lever.y(),
                                         motion.yaw_rate_radps * lever.x(), 0.0);
  return {T_map_vehicle * T_vehicle_radar, T_map_vehicle.rotation * velocity_vehicle};
}

}  // namespace dcloc::simulation
