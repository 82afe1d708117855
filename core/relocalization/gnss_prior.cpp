#include "core/relocalization/gnss_prior.h"

#include <numbers>

#include "core/geometry/covariance.h"
#include "core/geometry/degrees.h"
#include "core/geometry/geodetic_heading.h"

namespace dcloc {
namespace {

/// A heading that nobody knows is uniform over the circle.
constexpr double kUnknownYawVariance_rad2 = std::numbers::pi * std::numbers::pi / 3.0;
/// A receiver says nothing of roll and pitch; a road vehicle stays within a few degrees.
constexpr double kRollPitchSigma_rad = 3.0 * kRadPerDeg;

}  // namespace

InitialPose PriorFromPosition(const MapPosition& position) {
  const double horizontal_m2 = position.horizontal_sigma_m * position.horizontal_sigma_m;
  const double yaw_rad2 =
      position.yaw_rad ? position.yaw_sigma_rad * position.yaw_sigma_rad : kUnknownYawVariance_rad2;
  InitialPose pose;
  pose.T_map_vehicle.translation_m = position.p_map;
  pose.T_map_vehicle.rotation =
      Eigen::AngleAxisd(position.yaw_rad.value_or(0.0), Eigen::Vector3d::UnitZ());
  // The same along every horizontal axis, hence the same in the map's and the vehicle's frame.
  pose.covariance =
      EmbedCovariance(Eigen::Vector3d(horizontal_m2, horizontal_m2, yaw_rad2).asDiagonal(),
                      position.vertical_sigma_m * position.vertical_sigma_m,
                      kRollPitchSigma_rad * kRollPitchSigma_rad);
  return pose;
}

InitialPose PriorFromGnss(const GnssFix& fix, const GeodeticAnchor& anchor) {
  MapPosition position{.p_map = MapFromGeodetic(anchor, fix.position),
                       .horizontal_sigma_m = fix.horizontal_sigma_m,
                       .vertical_sigma_m = fix.vertical_sigma_m,
                       .yaw_rad = std::nullopt,
                       .yaw_sigma_rad = fix.heading_sigma_deg * kRadPerDeg};
  if (fix.heading_deg) position.yaw_rad = YawFromHeading(anchor, fix.position, *fix.heading_deg);
  return PriorFromPosition(position);
}

}  // namespace dcloc
