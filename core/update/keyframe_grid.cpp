#include "core/update/keyframe_grid.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

namespace dcloc {

KeyframeGrid::KeyframeGrid(std::span<const Pose3> T_local_keyframes) {
  for (const Pose3& T_local_keyframe : T_local_keyframes) {
    positions_m_.emplace_back(T_local_keyframe.translation_m.head<2>());
    grid_.Insert(positions_m_.back());
  }
}

// A wider and wider box, until it holds all that could be nearer than the nearest one in it.
std::size_t KeyframeGrid::Nearest(const Eigen::Vector2d& p_local_m) const {
  using Candidate = std::pair<double, std::uint32_t>;  // its squared distance, its number
  Candidate nearest = {std::numeric_limits<double>::infinity(), 0};
  double reach_m = 0.5 * kCell_m;
  do {
    reach_m *= 2.0;
    grid_.ForEachNear(p_local_m, Eigen::Vector2d::Constant(reach_m), [&](std::uint32_t i) {
      nearest = std::min(nearest, Candidate((p_local_m - positions_m_[i]).squaredNorm(), i));
    });
  } while (nearest.first > reach_m * reach_m);
  return nearest.second;
}

}  // namespace dcloc
