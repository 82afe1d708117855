#include "client/simulation/world/structures.h"
#include "client/simulation/world/steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dcloc::simulation {
namespace {

double HeadingOf(const Eigen::Vector2d& direction) {
  return std::atan2(direction.y(), direction.x());
}

}  // namespace

void Builder::Add(const Scatterer& scatterer) {
  world_.scatterers.push_back(scatterer);
  world_.scatterers.back().id = static_cast<std::uint32_t>(world_.scatterers.size());
}

void Builder::AddFacadeElement(const Eigen::Vector2d& foot, double outward_rad, double height_m) {
  Scatterer scatterer;
  const Eigen::Vector2d position = foot + Uniform(random_, 0.02, 0.3) * Along(outward_rad);
  scatterer.position_m << position, Uniform(random_, 0.3, std::min(height_m, 7.0));
  scatterer.rcs_dbsm = Normal(random_, 1.0, 5.0);
  scatterer.facing_rad = outward_rad + Uniform(random_, -0.35, 0.35);
  scatterer.half_sector_rad = Uniform(random_, 0.7, 1.3);
  scatterer.extent_m = Uniform(random_, 0.02, 0.12);
  const double kind = Uniform(random_, 0.0, 1.0);
  if (kind < 0.35) {
    // Reveals and balconies are dihedrals: strong, and open to one side along the street.
    scatterer.rcs_dbsm += 4.0;
    scatterer.facing_rad =
        outward_rad + (Chance(random_, 0.5) ? 1.0 : -1.0) * Uniform(random_, 0.7, 1.3);
    scatterer.half_sector_rad = Uniform(random_, 0.4, 0.8);
  } else if (kind < 0.55) {
    // Downpipes, lamps and shop signs stand out of the wall: seen along it from both sides.
    scatterer.facing_rad = outward_rad;
    scatterer.half_sector_rad = 0.5 * std::numbers::pi;
  }
  Add(scatterer);
}

void Builder::AddFacade(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double height_m) {
  const double length_m = (end - begin).norm();
  const Eigen::Vector2d along = (end - begin) / length_m;
  const double outward_rad = HeadingOf(along) - 0.5 * std::numbers::pi;
  world_.walls.push_back({begin, end, height_m, kOpaqueDb, true});
  std::exponential_distribution<double> spacing(1.0 / 0.7);
  double at = spacing(random_);
  while (at < length_m) {
    AddFacadeElement(begin + at * along, outward_rad, height_m);
    at += 0.15 + spacing(random_);
  }
}

void Builder::AddBuilding(const Footprint& footprint, double height_m) {
  const Eigen::Vector2d centre = 0.25 * (footprint[0] + footprint[1] + footprint[2] + footprint[3]);
  for (std::size_t i = 0; i < 4; ++i) {
    AddFacade(footprint[i], footprint[(i + 1) % 4], height_m);
    const Eigen::Vector2d outward = (footprint[i] - centre).normalized();
    Eigen::Vector3d corner;
    corner << footprint[i] + 0.1 * outward, Uniform(random_, 0.4, 2.5);
    AddPlate(corner, HeadingOf(outward), 1.5, Normal(random_, 11.0, 3.0));
  }
}

void Builder::AddBarrier(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double height_m,
                         double post_spacing_m) {
  const double length_m = (end - begin).norm();
  const Eigen::Vector2d along = (end - begin) / length_m;
  const double outward_rad = HeadingOf(along) - 0.5 * std::numbers::pi;
  world_.walls.push_back({begin, end, height_m, kOpaqueDb, true});
  for (const double at : Steps(0.0, length_m, post_spacing_m)) {
    const Eigen::Vector2d post =
        begin + (at + Normal(random_, 0.0, 0.05)) * along + 0.1 * Along(outward_rad);
    Eigen::Vector3d position;
    position << post, Uniform(random_, 0.3, height_m);
    AddPlate(position, outward_rad + Uniform(random_, -0.3, 0.3), 1.35, Normal(random_, 0.0, 5.0));
    if (Chance(random_, 0.3)) {
      AddFacadeElement(begin + (at + Uniform(random_, 0.5, 3.5)) * along, outward_rad, height_m);
    }
  }
}

void Builder::AddRailSegment(const Eigen::Vector2d& begin, const Eigen::Vector2d& end) {
  const double heading_rad = HeadingOf(end - begin);
  world_.walls.push_back({begin, end, 0.75, 0.0, true});
  const Eigen::Vector2d post = begin + Normal(random_, 0.0, 0.05) * Along(heading_rad);
  Scatterer scatterer;
  scatterer.position_m << post, Uniform(random_, 0.4, 0.7);
  scatterer.rcs_dbsm = Normal(random_, -1.0, 5.0);
  scatterer.extent_m = 0.05;
  Add(scatterer);
}

void Builder::AddPole(const Eigen::Vector2d& position, double rcs_dbsm, double height_m,
                      double extent_m) {
  Scatterer scatterer;
  scatterer.position_m << position, Uniform(random_, 0.2, height_m);
  scatterer.rcs_dbsm = rcs_dbsm;
  scatterer.extent_m = extent_m;
  Add(scatterer);
}

void Builder::AddPlate(const Eigen::Vector3d& position, double facing_rad, double half_sector_rad,
                       double rcs_dbsm) {
  Scatterer scatterer;
  scatterer.position_m = position;
  scatterer.rcs_dbsm = rcs_dbsm;
  scatterer.facing_rad = facing_rad;
  scatterer.half_sector_rad = half_sector_rad;
  scatterer.extent_m = 0.05;
  Add(scatterer);
}

}  // namespace dcloc::simulation
