#pragma once

#include <Eigen/Core>
#include <vector>

#include "client/simulation/world/scatterer.h"

namespace dcloc::simulation {

/// Answers what stands between one viewpoint and a place. Walls are sorted into bins of direction
/// once, so that a ray meets only those that it can cross.
class Occlusion {
 public:
  explicit Occlusion(const Eigen::Vector3d& viewpoint);

  void Add(const Wall& wall);

  /// Loss of the straight path to `target`, one way [dB]; kOpaqueDb or more when blocked. What lies
  /// within `skin_m` before the target belongs to it and does not count.
  double LossDb(const Eigen::Vector3d& target, double skin_m) const;

  const std::vector<Wall>& walls() const { return walls_; }
  const Eigen::Vector3d& viewpoint() const { return viewpoint_; }

 private:
  Eigen::Vector3d viewpoint_;
  std::vector<Wall> walls_;
  std::vector<std::vector<std::size_t>> bins_;
};

/// Where the segment from `from` to `to` crosses the wall, as a share of the segment in (0, 1);
/// negative when it does not.
double CrossingShare(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Wall& wall);

}  // namespace dcloc::simulation
