#include "core/update/updated_keyframes.h"

#include <vector>

#include "core/map/keyframe_index.h"

namespace dcloc {
namespace {

std::vector<Pose3> Joined(std::span<const Pose3> one, std::span<const Pose3> other) {
  std::vector<Pose3> poses(one.begin(), one.end());
  poses.insert(poses.end(), other.begin(), other.end());
  return poses;
}

}  // namespace

UpdatedKeyframes::UpdatedKeyframes(std::span<const Pose3> base, std::span<const Pose3> joined)
    : grid_(Joined(base, joined)), base_count_(base.size()), any_joined_(!joined.empty()) {}

std::optional<std::size_t> UpdatedKeyframes::Of(const Landmark& landmark) const {
  const Eigen::Vector2d p_local_m = landmark.position_m.head<2>();
  const std::size_t nearest = grid_.Nearest(p_local_m);
  const double distance_m = (grid_.position_m(nearest) - p_local_m).norm();
  if (distance_m >= kMaxKeyframeDistance_m) return std::nullopt;
  return nearest;
}

bool UpdatedKeyframes::IsInJoinedStreet(const Landmark& landmark) const {
  const std::optional<std::size_t> keyframe = Of(landmark);
  return keyframe && *keyframe >= base_count_;
}

}  // namespace dcloc
