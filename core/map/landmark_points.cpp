#include "core/map/landmark_points.h"

#include <algorithm>
#include <array>
#include <limits>

namespace dcloc {
namespace {

std::uint16_t Saturate(std::uint32_t count) {
  return static_cast<std::uint16_t>(
      std::min<std::uint32_t>(count, std::numeric_limits<std::uint16_t>::max()));
}

std::array<float, 6> UpperTriangle(const Eigen::Matrix3d& covariance_m2) {
  const Eigen::Matrix3f c = covariance_m2.cast<float>();
  return {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
}

}  // namespace

void AppendReturns(std::span<const RadarPoint> points, const Pose3& T_local_vehicle,
                   std::uint32_t scan, std::vector<MapReturn>& returns) {
  const Eigen::Matrix3d rotation = T_local_vehicle.Rotation();
  for (const RadarPoint& point : points) {
    const Eigen::Vector2f slant_per_m =
        (rotation.topLeftCorner<2, 2>() * point.slant_per_m).cast<float>();
    returns.push_back(
        {.position_m = T_local_vehicle * point.position_m,
         .covariance_m2 = UpperTriangle(rotation * point.covariance_m2 * rotation.transpose()),
         .rcs_dbsm = point.rcs_dbsm,
         .scan = scan,
         .slant_per_m = {slant_per_m.x(), slant_per_m.y()}});
  }
}

MapPoint PointInKeyframe(const Landmark& landmark, const Pose3& T_local_keyframe,
                         bool has_heights) {
  const Pose3 T_keyframe_local = T_local_keyframe.Inverse();
  const Eigen::Matrix3d rotation = T_keyframe_local.Rotation();
  const Eigen::Vector3f p = (T_keyframe_local * landmark.position_m).cast<float>();
  const float z_m = has_heights ? static_cast<float>(landmark.height_m) : p.z();
  const std::array<float, 6> c =
      UpperTriangle(rotation * landmark.covariance_m2 * rotation.transpose());
  return {.x_m = p.x(),
          .y_m = p.y(),
          .z_m = z_m,
          .xx_m2 = c[0],
          .xy_m2 = c[1],
          .xz_m2 = c[2],
          .yy_m2 = c[3],
          .yz_m2 = c[4],
          .zz_m2 = c[5],
          .rcs_dbsm = landmark.rcs_dbsm,
          .scan_count = Saturate(landmark.scan_count),
          .pass_count = Saturate(landmark.pass_count)};
}

}  // namespace dcloc
