#pragma once

#include <vector>

#include "core/geometry/pose.h"
#include "core/map/editable_map.h"
#include "core/update/center_matching.h"
#include "core/update/version_score.h"

namespace dcloc {

/// The landmarks of a map in its local frame.
struct BaseLandmarks {
  explicit BaseLandmarks(const EditableMap& map) {
    landmarks = LandmarksOf(map);
    for (const PlacedLandmark& landmark : landmarks) {
      positions.push_back(landmark.position);
      scans.push_back(landmark.point.scan_count);
    }
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
