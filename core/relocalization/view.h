#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/odometry/motion.h"

namespace dcloc {

/// A sub-map that global localization keeps, and how the vehicle moved to there since the view
/// before.
template <int Dim>
struct View {
  std::vector<GaussianPoint<Dim>> fine_points;
  std::vector<GaussianPoint<Dim>> coarse_points;
  Motion motion;
  double travelled_m = 0.0;
};

/// xy of each point.
template <int Dim>
std::vector<Eigen::Vector2f> PositionsOf(std::span<const GaussianPoint<Dim>> points) {
  std::vector<Eigen::Vector2f> positions;
  positions.reserve(points.size());
  for (const GaussianPoint<Dim>& point : points) {
    positions.push_back(point.mean_m.template head<2>().template cast<float>());
  }
  return positions;
}

}  // namespace dcloc
