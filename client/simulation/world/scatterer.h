#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>

namespace dcloc::simulation {

/// One persistent place of an object that sends radar power back: a window reveal, a rail post.
struct Scatterer {
  Eigen::Vector3d position_m;
  double rcs_dbsm = 0.0;  ///< where it looks straight at the radar
  /// The middle of the directions (in the plane) from which it is seen, and half their spread;
  /// pi sees all round.
  double facing_rad = 0.0;
  double half_sector_rad = std::numbers::pi;
  /// The reflection wanders over the object by this much (standard deviation) from scan to scan.
  double extent_m = 0.0;
  /// Seed of its own lobes and of its ghosts.
  std::uint32_t id = 0;
};

/// A vertical flat surface on the ground from `begin_m` to `end_m`.
struct Wall {
  Eigen::Vector2d begin_m;
  Eigen::Vector2d end_m;
  double height_m = 0.0;
  double loss_db = 0.0;    ///< of a ray through it, one way; kOpaqueDb blocks
  bool is_mirror = false;  ///< large and flat enough for glints and mirror ghosts
  /// So smooth that it reflects from this many places a metre, elsewhere in every scan; 0 for
  /// walls whose places persist and are scatterers.
  double reflections_per_m = 0.0;
};

inline constexpr double kOpaqueDb = 200.0;

}  // namespace dcloc::simulation
