#include "core/passes/placed_landmark.h"

namespace dcloc {

std::vector<PlacedLandmark> LandmarksOf(const EditableMap& map) {
  std::vector<PlacedLandmark> landmarks;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Pose3 T_local_keyframe = PoseOf(map.keyframes[k].record);
    const Eigen::Matrix3d rotation = T_local_keyframe.Rotation();
    for (const MapPoint& point : map.keyframes[k].points) {
      Eigen::Vector3d p_keyframe = PositionOf(point);
      if ((map.info.flags & kHasHeightsFlag) != 0) p_keyframe.z() = 0.0;
      Eigen::Matrix3d covariance;
      covariance << point.xx_m2, point.xy_m2, point.xz_m2, point.xy_m2, point.yy_m2, point.yz_m2,
          point.xz_m2, point.yz_m2, point.zz_m2;
      covariance = rotation * covariance * rotation.transpose();
      landmarks.push_back({.position = {.position_m = (T_local_keyframe * p_keyframe).head<2>(),
                                        .covariance_m2 = covariance.topLeftCorner<2, 2>()},
                           .keyframe = k,
                           .point = point});
    }
  }
  return landmarks;
}

std::vector<LandmarkPosition> PositionsOf(std::span<const PlacedLandmark> landmarks) {
  std::vector<LandmarkPosition> positions;
  positions.reserve(landmarks.size());
  for (const PlacedLandmark& landmark : landmarks) positions.push_back(landmark.position);
  return positions;
}

}  // namespace dcloc
