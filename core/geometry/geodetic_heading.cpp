#include "core/geometry/geodetic_heading.h"

#include <cmath>

#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

/// East-north-up axes at `position` as an anchor of their own.
GeodeticAnchor LocalTangentPlane(const GeodeticPosition& position) {
  return {.origin = position, .x_axis_east_rad = 0.0};
}

}  // namespace

double HeadingFromMap(const GeodeticAnchor& anchor, const Pose3& T_map_vehicle) {
  const GeodeticPosition position = GeodeticFromMap(anchor, T_map_vehicle.translation_m);
  const GeodeticPosition ahead =
      GeodeticFromMap(anchor, T_map_vehicle * Eigen::Vector3d(1.0, 0.0, 0.0));
  const Eigen::Vector3d ahead_enu = MapFromGeodetic(LocalTangentPlane(position), ahead);
  double heading_deg = std::atan2(ahead_enu.x(), ahead_enu.y()) * kDegPerRad;
  if (heading_deg < 0.0) heading_deg += 360.0;
  return heading_deg < 360.0 ? heading_deg : 0.0;
}

double YawFromHeading(const GeodeticAnchor& anchor, const GeodeticPosition& position,
                      double heading_deg) {
  const double heading_rad = heading_deg / kDegPerRad;
  const GeodeticPosition ahead =
      GeodeticFromMap(LocalTangentPlane(position),
                      Eigen::Vector3d(std::sin(heading_rad), std::cos(heading_rad), 0.0));
  const Eigen::Vector3d ahead_map =
      MapFromGeodetic(anchor, ahead) - MapFromGeodetic(anchor, position);
  return std::atan2(ahead_map.y(), ahead_map.x());
}

}  // namespace dcloc
