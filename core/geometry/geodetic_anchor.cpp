#include "core/geometry/geodetic_anchor.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

absl::Status CheckBound(const char* field, double value, double bound) {
  if (std::isfinite(value) && std::abs(value) <= bound) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must lie in [%g, %g]", field, value, -bound, bound));
}

GeographicLib::LocalCartesian LocalFrame(const GeodeticAnchor& anchor) {
  return {anchor.origin.latitude_deg, anchor.origin.longitude_deg, anchor.origin.height_m};
}

Eigen::Quaterniond EnuFromMap(const GeodeticAnchor& anchor) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(anchor.x_axis_east_rad, Eigen::Vector3d::UnitZ()));
}

}  // namespace

absl::Status Validate(const GeodeticPosition& position) {
  absl::Status status = CheckBound("latitude_deg", position.latitude_deg, 90.0);
  status.Update(CheckBound("longitude_deg", position.longitude_deg, 180.0));
  status.Update(CheckBound("height_m", position.height_m, 1e5));
  return status;
}

absl::Status Validate(const GeodeticAnchor& anchor) {
  absl::Status status = Validate(anchor.origin);
  status.Update(CheckBound("x_axis_east_rad", anchor.x_axis_east_rad, 6.2832));
  return status;
}

GeodeticPosition GeodeticFromMap(const GeodeticAnchor& anchor, const Eigen::Vector3d& p_map) {
  const Eigen::Vector3d p_enu = EnuFromMap(anchor) * p_map;
  GeodeticPosition position;
  LocalFrame(anchor).Reverse(p_enu.x(), p_enu.y(), p_enu.z(), position.latitude_deg,
                             position.longitude_deg, position.height_m);
  return position;
}

Eigen::Vector3d MapFromGeodetic(const GeodeticAnchor& anchor, const GeodeticPosition& position) {
  Eigen::Vector3d p_enu;
  LocalFrame(anchor).Forward(position.latitude_deg, position.longitude_deg, position.height_m,
                             p_enu.x(), p_enu.y(), p_enu.z());
  return EnuFromMap(anchor).conjugate() * p_enu;
}

}  // namespace dcloc
