#include "core/versions/street_segments.h"

#include <algorithm>

namespace dcloc {

StreetSegments::StreetSegments(const EditableMap& map, double segment_m) {
  double at_m = 0.0;
  for (const EditableKeyframe& keyframe : map.keyframes) {
    const Eigen::Vector2d p_m = PoseOf(keyframe.record).translation_m.head<2>();
    if (!keyframes_m_.empty()) at_m += std::min((p_m - keyframes_m_.back()).norm(), segment_m);
    keyframes_m_.push_back(p_m);
    segment_of_.push_back(static_cast<std::size_t>(at_m / segment_m));
  }
}

std::size_t StreetSegments::KeyframeAt(const Eigen::Vector2d& p_local_m) const {
  const auto nearest = std::ranges::min_element(keyframes_m_, {}, [&](const Eigen::Vector2d& p_m) {
    return (p_m - p_local_m).squaredNorm();
  });
  return static_cast<std::size_t>(nearest - keyframes_m_.begin());
}

Eigen::Vector2d StreetSegments::Middle(std::size_t segment) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (std::size_t k = 0; k < segment_of_.size(); ++k) {
    if (segment_of_[k] != segment) continue;
    sum += keyframes_m_[k];
    count += 1.0;
  }
  return sum / std::max(1.0, count);
}

}  // namespace dcloc
