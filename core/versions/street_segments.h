#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/map/editable_map.h"

namespace dcloc {

/// Street segments of about equal length along the keyframes of a map, numbered from 0. Positions
/// are relative to the map's local origin [m].
class StreetSegments {
 public:
  /// `map` has a keyframe; `segment_m` > 0 is the length of each.
  StreetSegments(const EditableMap& map, double segment_m);

  std::size_t count() const { return segment_of_.back() + 1; }

  std::size_t OfKeyframe(std::size_t keyframe) const { return segment_of_[keyframe]; }

  /// The keyframe that is nearest to `p_local_m`, and its segment.
  std::size_t KeyframeAt(const Eigen::Vector2d& p_local_m) const;
  std::size_t At(const Eigen::Vector2d& p_local_m) const {
    return segment_of_[KeyframeAt(p_local_m)];
  }

  /// The mean of the keyframes of a segment, relative to the local origin.
  Eigen::Vector2d Middle(std::size_t segment) const;

 private:
  std::vector<Eigen::Vector2d> keyframes_m_;
  std::vector<std::size_t> segment_of_;  // of each keyframe
};

}  // namespace dcloc
