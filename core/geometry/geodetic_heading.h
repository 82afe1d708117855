#pragma once

#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"

namespace dcloc {

// Headings are in degrees, clockwise from true north. North at one place of a map is not quite
// north at another, so directions go over the Earth.

/// Heading in [0, 360) of the x axis of what stands at `T_map_vehicle`.
double HeadingFromMap(const GeodeticAnchor& anchor, const Pose3& T_map_vehicle);

/// Yaw [rad] in the map frame of what has `heading_deg` at `position`.
double YawFromHeading(const GeodeticAnchor& anchor, const GeodeticPosition& position,
                      double heading_deg);

}  // namespace dcloc
