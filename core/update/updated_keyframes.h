#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/map/landmark_fusion.h"

namespace dcloc {

/// The keyframes of a new version, in the map's local frame: the base map's, and then those of the
/// streets that join it.
class UpdatedKeyframes {
 public:
  UpdatedKeyframes(std::span<const Pose3> base, std::span<const Pose3> joined);

  /// The keyframe that `landmark` belongs to; none where all are too far.
  std::optional<std::size_t> Of(const Landmark& landmark) const;

  bool AnyJoined() const { return T_local_keyframes_.size() > base_count_; }
  bool IsInJoinedStreet(const Landmark& landmark) const;

 private:
  std::vector<Pose3> T_local_keyframes_;
  std::size_t base_count_;
};

}  // namespace dcloc
