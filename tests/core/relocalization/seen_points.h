#pragma once

#include <random>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {

/// What stands within sight ahead of a vehicle, in its frame, measured to a decimetre.
inline std::vector<GaussianPoint<2>> SeenFrom(const SyntheticWorld& world,
                                              const Pose3& T_map_vehicle, double sight_m,
                                              std::mt19937& random) {
  std::normal_distribution<double> noise_m(0.0, 0.1);
  std::vector<GaussianPoint<2>> points;
  for (const Eigen::Vector3d& scatterer_m : world.scatterers_m) {
    const Eigen::Vector3d p = T_map_vehicle.Inverse() * scatterer_m;
    if (p.x() < 5.0 || p.norm() > sight_m) continue;
    points.push_back({.mean_m = p.head<2>() + Eigen::Vector2d(noise_m(random), noise_m(random)),
                      .covariance_m2 = 0.02 * Eigen::Matrix2d::Identity()});
  }
  return points;
}

}  // namespace dcloc
