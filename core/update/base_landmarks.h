#pragma once

#include <vector>

#include "core/geometry/pose.h"
#include "core/map/editable_map.h"
#include "core/passes/placed_landmark.h"

namespace dcloc {

/// The landmarks of a map in its local frame.
struct BaseLandmarks {
  explicit BaseLandmarks(const EditableMap& map)
      : landmarks(LandmarksOf(map)), positions(PositionsOf(landmarks)) {
    for (const PlacedLandmark& landmark : landmarks) scans.push_back(landmark.point.scan_count);
    for (const EditableKeyframe& keyframe : map.keyframes) {
      T_local_keyframes.push_back(PoseOf(keyframe.record));
    }
  }

  std::vector<PlacedLandmark> landmarks;
  std::vector<LandmarkPosition> positions;
  std::vector<int> scans;
  std::vector<Pose3> T_local_keyframes;
};

}  // namespace dcloc
