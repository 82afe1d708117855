#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/map/point_grid.h"

namespace dcloc {

/// Keyframes by where they lie in the plane.
class KeyframeGrid {
 public:
  /// `T_local_keyframes` are at least one.
  explicit KeyframeGrid(std::span<const Pose3> T_local_keyframes);

  /// The number of the keyframe that is nearest to `p_local_m`, the first one of several.
  std::size_t Nearest(const Eigen::Vector2d& p_local_m) const;

  const Eigen::Vector2d& position_m(std::size_t keyframe) const { return positions_m_[keyframe]; }

 private:
  static constexpr double kCell_m = 20.0;

  std::vector<Eigen::Vector2d> positions_m_;
  PointGrid grid_{kCell_m};
};

}  // namespace dcloc
