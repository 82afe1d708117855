#pragma once

#include <Eigen/Core>

#include "absl/status/status.h"
#include "core/geometry/pose.h"

namespace dcloc {

/// WGS 84 position.
struct GeodeticPosition {
  double latitude_deg = 0.0;   ///< [-90, 90]
  double longitude_deg = 0.0;  ///< [-180, 180]
  double height_m = 0.0;       ///< above the ellipsoid
};

/// Ties a map frame to the Earth: `origin` is where the map's (0, 0, 0) lies, and the map's x axis
/// points `x_axis_east_rad` counter-clockwise from east in the tangent plane there; z is up.
struct GeodeticAnchor {
  GeodeticPosition origin;
  double x_axis_east_rad = 0.0;
};

/// InvalidArgument naming the field, its value and its bound; OK otherwise.
absl::Status Validate(const GeodeticPosition& position);
absl::Status Validate(const GeodeticAnchor& anchor);

/// Map coordinates [m] to WGS 84 and back, exact on the ellipsoid (GeographicLib).
GeodeticPosition GeodeticFromMap(const GeodeticAnchor& anchor, const Eigen::Vector3d& p_map);
Eigen::Vector3d MapFromGeodetic(const GeodeticAnchor& anchor, const GeodeticPosition& position);

}  // namespace dcloc
