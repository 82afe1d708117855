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

InitialPose PriorFromGnss(const GnssFix& fix, const GeodeticAnchor& anchor) {
  const double horizontal_m2 = fix.horizontal_sigma_m * fix.horizontal_sigma_m;
  const double heading_sigma_rad = fix.heading_sigma_deg * kRadPerDeg;
  const double yaw_rad =
      fix.heading_deg ? YawFromHeading(anchor, fix.position, *fix.heading_deg) : 0.0;
  const double yaw_rad2 =
      fix.heading_deg ? heading_sigma_rad * heading_sigma_rad : kUnknownYawVariance_rad2;
  InitialPose pose;
  pose.T_map_vehicle.translation_m = MapFromGeodetic(anchor, fix.position);
  pose.T_map_vehicle.rotation = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  // The same along every horizontal axis, hence the same in the map's and the vehicle's frame.
  pose.covariance = EmbedCovariance(
      Eigen::Vector3d(horizontal_m2, horizontal_m2, yaw_rad2).asDiagonal(),
      fix.vertical_sigma_m * fix.vertical_sigma_m, kRollPitchSigma_rad * kRollPitchSigma_rad);
  return pose;
}

}  // namespace dcloc
