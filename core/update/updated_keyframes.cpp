#include "core/update/updated_keyframes.h"

#include "core/map/keyframe_index.h"

namespace dcloc {

UpdatedKeyframes::UpdatedKeyframes(std::span<const Pose3> base, std::span<const Pose3> joined)
    : T_local_keyframes_(base.begin(), base.end()), base_count_(base.size()) {
  T_local_keyframes_.insert(T_local_keyframes_.end(), joined.begin(), joined.end());
}

std::optional<std::size_t> UpdatedKeyframes::Of(const Landmark& landmark) const {
  std::optional<std::size_t> nearest;
  double nearest_m = kMaxKeyframeDistance_m;
  for (std::size_t k = 0; k < T_local_keyframes_.size(); ++k) {
    const double distance_m =
        (T_local_keyframes_[k].translation_m - landmark.position_m).head<2>().norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = k;
  }
  return nearest;
}

bool UpdatedKeyframes::IsInJoinedStreet(const Landmark& landmark) const {
  const std::optional<std::size_t> keyframe = Of(landmark);
  return keyframe && *keyframe >= base_count_;
}

}  // namespace dcloc
