#include "client/trajectory/trajectory.h"

#include <algorithm>
#include <utility>

namespace dcloc {

void SortByStamp(std::vector<TrajectoryPose>& poses) {
  std::ranges::stable_sort(poses, {}, &TrajectoryPose::stamp);
  std::vector<TrajectoryPose> unique;
  unique.reserve(poses.size());
  for (const TrajectoryPose& pose : poses) {
    if (!unique.empty() && unique.back().stamp == pose.stamp) unique.pop_back();
    unique.push_back(pose);
  }
  poses = std::move(unique);
}

}  // namespace dcloc
