#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/map/editable_map.h"
#include "core/passes/center_matching.h"

namespace dcloc {

/// A landmark of a map in the plane of the map's local frame.
struct PlacedLandmark {
  LandmarkPosition position;
  std::size_t keyframe = 0;
  MapPoint point{};
};

/// All landmarks of `map`, keyframe by keyframe.
std::vector<PlacedLandmark> LandmarksOf(const EditableMap& map);

/// Where `landmarks` lie, in their order.
std::vector<LandmarkPosition> PositionsOf(std::span<const PlacedLandmark> landmarks);

}  // namespace dcloc
