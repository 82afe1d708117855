#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/geometry/thinning.h"
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

/// `max_count` points, or all, evenly among them (EvenIndex).
template <int Dim>
std::vector<GaussianPoint<Dim>> EvenSubsample(std::span<const GaussianPoint<Dim>> points,
                                              int max_count) {
  std::vector<GaussianPoint<Dim>> chosen;
  const std::size_t count = std::min(points.size(), static_cast<std::size_t>(max_count));
  chosen.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    chosen.push_back(points[EvenIndex(i, count, points.size())]);
  }
  return chosen;
}

}  // namespace dcloc
