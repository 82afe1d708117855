#pragma once

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

/// The fix as a pose in the map with that anchor: level, and with a yaw of any value where the fix
/// has no heading.
InitialPose PriorFromGnss(const GnssFix& fix, const GeodeticAnchor& anchor);

}  // namespace dcloc
