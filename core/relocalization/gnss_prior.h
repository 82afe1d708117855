#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/geodetic_anchor.h"
#include "core/relocalization/initial_pose.h"

namespace dcloc {

/// One fix of a satellite receiver.
struct GnssFix {
  GeodeticPosition position;
  double horizontal_sigma_m = 0.0;  ///< along each horizontal axis
  double vertical_sigma_m = 0.0;
  std::optional<double> heading_deg;  ///< of the vehicle, clockwise from true north
  double heading_sigma_deg = 0.0;     ///< where there is a heading
};

/// A position in the map, of whatever source, and perhaps a yaw.
struct MapPosition {
  Eigen::Vector3d p_map;
  double horizontal_sigma_m = 0.0;  ///< along each horizontal axis
  double vertical_sigma_m = 0.0;
  std::optional<double> yaw_rad;
  double yaw_sigma_rad = 0.0;  ///< where there is a yaw
};

/// The position as a pose: level within a few degrees, and with a yaw of any value where none is
/// known.
InitialPose PriorFromPosition(const MapPosition& position);

/// The fix as a pose in the map with that anchor: level, and with a yaw of any value where the fix
/// has no heading.
InitialPose PriorFromGnss(const GnssFix& fix, const GeodeticAnchor& anchor);

}  // namespace dcloc
