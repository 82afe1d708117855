#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "core/geometry/pose.h"
#include "core/map/landmark_fusion.h"
#include "core/update/keyframe_grid.h"

namespace dcloc {

/// The keyframes of a new version, in the map's local frame: the base map's, at least one, and then
/// those of the streets that join it.
class UpdatedKeyframes {
 public:
  UpdatedKeyframes(std::span<const Pose3> base, std::span<const Pose3> joined);

  /// The keyframe that `landmark` belongs to; none where all are too far.
  std::optional<std::size_t> Of(const Landmark& landmark) const;

  bool AnyJoined() const { return any_joined_; }
  bool IsInJoinedStreet(const Landmark& landmark) const;

 private:
  KeyframeGrid grid_;
  std::size_t base_count_;
  bool any_joined_;
};

}  // namespace dcloc
