#pragma once

#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"

namespace dcloc {

// Headings are in degrees, clockwise from true north. The direction of north differs between places
// of a map, so it is computed on the ellipsoid at each place.

/// Heading of the vehicle's x axis, in [0, 360).
double HeadingFromMap(const GeodeticAnchor& anchor, const Pose3& T_map_vehicle);

/// Yaw [rad] in the map frame of a vehicle with `heading_deg` at `position`.
double YawFromHeading(const GeodeticAnchor& anchor, const GeodeticPosition& position,
                      double heading_deg);

}  // namespace dcloc
