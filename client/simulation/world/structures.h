#pragma once

#include <Eigen/Core>
#include <array>

#include "client/simulation/world/random.h"
#include "client/simulation/world/world.h"

namespace dcloc::simulation {

/// Corners of an upright box on the ground, counter-clockwise from above.
using Footprint = std::array<Eigen::Vector2d, 4>;

/// Adds the parts of a world, each with the scatterers that a 77 GHz radar sees of it.
class Builder {
 public:
  Builder(World& world, Random& random) : world_(world), random_(random) {}

  /// Four opaque walls with window reveals, balconies and pipes at irregular distances, and
  /// corners.
  void AddBuilding(const Footprint& footprint, double height_m);

  /// An opaque wall seen from the right of `begin` -> `end`, with posts at `post_spacing_m`.
  void AddBarrier(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double height_m,
                  double post_spacing_m);

  /// A steel rail seen from both sides that mirrors but hides nothing; one piece between posts.
  void AddRailSegment(const Eigen::Vector2d& begin, const Eigen::Vector2d& end);

  /// Lamps, signs, trees: seen from all round.
  void AddPole(const Eigen::Vector2d& position, double rcs_dbsm, double height_m, double extent_m);

  /// A plate: seen from about `facing_rad` +- `half_sector_rad`.
  void AddPlate(const Eigen::Vector3d& position, double facing_rad, double half_sector_rad,
                double rcs_dbsm);

 private:
  void AddFacade(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double height_m);
  void AddFacadeElement(const Eigen::Vector2d& foot, double outward_rad, double height_m);
  void Add(const Scatterer& scatterer);

  World& world_;
  Random& random_;
};

}  // namespace dcloc::simulation
