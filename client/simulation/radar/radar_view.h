#pragma once

#include <Eigen/Core>

#include "client/simulation/motion/ego_motion.h"
#include "core/geometry/pose.h"

namespace dcloc::simulation {

/// What a perfect radar without coupling would measure of one place.
struct Observation {
  double range_m = 0.0;
  double azimuth_rad = 0.0;
  double elevation_rad = 0.0;
  double range_rate_mps = 0.0;  ///< positive when the target recedes
};

/// A radar at one moment: where it is and how it moves.
struct RadarView {
  Pose3 T_map_radar;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< of the radar, in the map

  /// `velocity_map_mps` is the target's own.
  Observation Observe(const Eigen::Vector3d& p_map, const Eigen::Vector3d& velocity_map_mps) const;
};

RadarView ViewFrom(const MotionState& motion, const Pose3& T_vehicle_radar);

}  // namespace dcloc::simulation
